"""The verbs and their options. Bodies import what they need, so that `--help` stays fast."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import archsim
from archsim.cli.config_verbs import config_app
from archsim.cli.edge import at_the_edge
from archsim.cli.options import Jobs, Json, KernelName, Out, Overrides, RunName
from archsim.cli.sweep_verbs import sweep_app
from archsim.cli.trace_verbs import trace_app

app = typer.Typer(
    name="archsim",
    help="Cycle-approximate simulator of graphics-hardware architectures for shadow rendering.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for group in (config_app, sweep_app, trace_app):
    app.add_typer(group)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"archsim {archsim.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Options before the verb."""


@app.command("run")
@at_the_edge
def _run(
    config: RunName,
    overrides: Overrides = None,
    model: Annotated[
        str | None, typer.Option("--model", metavar="reference|compiled", help="The same as --set model=...")
    ] = None,
    out: Out = None,
    as_json: Json = False,
    cycles: Annotated[
        str | None,
        typer.Option(
            "--timeline",
            metavar="FIRST:LAST",
            help="Record these cycles of every phase, too: traces for Perfetto and waterfalls in the run folder.",
        ),
    ] = None,
) -> None:
    """Simulate one workload and leave a run folder (runs/NAME unless --out is given)."""
    from archsim.cli.run import run

    run(config, _with_model(overrides, model), out, as_json, cycles)


@app.command("reproduce")
@at_the_edge
def _reproduce(
    paper: Annotated[str, typer.Argument(metavar="[PAPER]")] = "johnson2004",
    out: Out = None,
    as_json: Json = False,
    figure: Annotated[
        int | None, typer.Option("--figure", metavar="NUMBER", help="One of its figures instead.")
    ] = None,
    frames: Annotated[
        int | None, typer.Option("--frames", min=1, metavar="N", help="Of each walkthrough, instead of all.")
    ] = None,
) -> None:
    """Regenerate a paper's tables, each printed number beside ours."""
    if figure is None:
        from archsim.cli.reproduce import reproduce

        reproduce(paper, out, as_json, frames)
    else:
        from archsim.cli.figure import reproduce_figure

        reproduce_figure(paper, figure, out, as_json)


@app.command("walkthrough")
@at_the_edge
def _walkthrough(
    config: Annotated[
        str,
        typer.Argument(metavar="CONFIG", help="A walkthrough's YAML file, or PAPER/ROW of an experiment."),
    ],
    overrides: Overrides = None,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Draw shadow volumes in every frame of a walkthrough, untimed. One that was killed goes on at the next frame."""
    from archsim.cli.walkthrough import walkthrough

    walkthrough(config, overrides or [], out, as_json)


@app.command("diff")
@at_the_edge
def _diff(
    left: Annotated[Path, typer.Argument(metavar="A", help="A run's folder.")],
    right: Annotated[Path, typer.Argument(metavar="B", help="Another one.")],
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="PERCENT", help="Changes up to this do not count.")
    ] = 0.0,
    limit: Annotated[int, typer.Option("--limit", min=0, help="Statistics to print; 0: all.")] = 20,
    as_json: Json = False,
    page: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="Write them as a page, too, images side by side."),
    ] = None,
) -> None:
    """Print in what two runs differ; exit code 0 if their results are equal, 1 if not."""
    from archsim.cli.diff import Shown, diff

    diff(left, right, tolerance, Shown(limit, as_json, page))


@app.command("whatif")
@at_the_edge
def _whatif(
    run: RunName,
    overrides: Overrides = None,
    out: Out = None,
    jobs: Jobs = 1,
    pairs: Annotated[bool, typer.Option("--pairs/--no-pairs", help="Two ideal parts at a time, too.")] = True,
    as_json: Json = False,
) -> None:
    """Make each part of a run's machine ideal in turn and print what that is worth, the most first."""
    from archsim.cli.whatif import whatif

    whatif(run, overrides or [], out, jobs, (pairs, as_json))


@app.command("timeline")
@at_the_edge
def _timeline(
    run: RunName,
    overrides: Overrides = None,
    phase: Annotated[str | None, typer.Option("--phase", metavar="PHASE")] = None,
    tasks: Annotated[
        str | None,
        typer.Option(
            "--tasks",
            metavar="FIRST:LAST",
            help="Record what happens while units do these tasks; of irregular shadow mapping play these only.",
        ),
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option("--unit", metavar="NAME", help="The unit whose tasks they are, instead of all."),
    ] = None,
    cycles: Annotated[
        str | None,
        typer.Option("--cycles", metavar="FIRST:LAST", help="Record these cycles of the phase, or of all."),
    ] = None,
    shown: Annotated[
        str | None,
        typer.Option("--waterfall", metavar="FIRST:LAST", help="Print these cycles thread by thread."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="FILE")] = Path("timeline.json"),
) -> None:
    """Write what threads or units, caches and DRAM banks did when, as a trace for Perfetto."""
    from archsim.cli.timeline import Wanted, timeline

    timeline(run, overrides or [], Wanted(phase, tasks, unit, cycles, shown), out)


@app.command("report")
@at_the_edge
def _report(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR...", help="Folders of runs, or one of a sweep.")
    ],
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="The page to write.")] = None,
) -> None:
    """Write one HTML page that compares runs with the first of them, or that shows a sweep."""
    from archsim.cli.report import report

    report(folders, out)


@app.command("statistics")
@at_the_edge
def _statistics(
    word: Annotated[str, typer.Argument(metavar="[WORD]", help="Only statistics with this in them.")] = "",
) -> None:
    """Print what every statistic of a run means: name, unit, definition."""
    from archsim.cli.statistics import print_statistics

    print_statistics(word)


@app.command("asm")
@at_the_edge
def _asm(
    file: KernelName,
) -> None:
    """Assemble a kernel and print its listing with static counts and live registers."""
    from archsim.cli.kernels import list_program

    list_program(file)


@app.command("disasm")
@at_the_edge
def _disasm(
    file: KernelName,
) -> None:
    """Assemble a kernel and print it in canonical form, which assembles again to the same program."""
    from archsim.cli.kernels import print_canonical

    print_canonical(file)


@app.command("bench")
@at_the_edge
def _bench(as_json: Json = False) -> None:
    """Measure simulated instructions a second and peak memory on this computer."""
    from archsim.cli.bench import bench

    bench(as_json)


def _with_model(overrides: list[str] | None, model: str | None) -> list[str]:
    return [*(overrides or []), *([f"model={model}"] if model else [])]
