"""The verbs and their options. Bodies import what they need, so that `--help` stays fast."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

import archsim
from archsim.cli.edge import at_the_edge
from archsim.cli.trace import trace_app

app = typer.Typer(
    name="archsim",
    help="Cycle-approximate simulator of graphics-hardware architectures for shadow rendering.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
config_app = typer.Typer(
    name="config", help="Check, show and explain configurations.", no_args_is_help=True, rich_markup_mode=None
)
app.add_typer(config_app)


class _RunByDefault(TyperGroup):
    """`archsim sweep FILE` is short for `archsim sweep run FILE`."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args and args[0] not in self.commands:
            args = ["run", *args]
        return super().resolve_command(ctx, args)


sweep_app = typer.Typer(
    name="sweep",
    help="Simulate many runs that differ in a few values: archsim sweep FILE. What is finished is never repeated.",
    no_args_is_help=True,
    rich_markup_mode=None,
    cls=_RunByDefault,
)
app.add_typer(sweep_app)
app.add_typer(trace_app)

Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Set a value, e.g. scene.resolution=[640,512]. Repeatable."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON to stdout and nothing else.")]
Out = Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Folder for the results.")]


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
    config: Annotated[
        str, typer.Argument(metavar="CONFIG", help="A run's YAML file, or a packaged run's name.")
    ],
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
) -> None:
    """Print in what two runs differ; exit code 0 if their results are equal, 1 if not."""
    from archsim.cli.diff import diff

    diff(left, right, tolerance, limit, as_json)


@app.command("whatif")
@at_the_edge
def _whatif(
    run: Annotated[str, typer.Argument(metavar="RUN", help="A run's YAML file, or a packaged run's name.")],
    overrides: Overrides = None,
    out: Out = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, metavar="N", help="Processes.")] = 1,
    pairs: Annotated[bool, typer.Option("--pairs/--no-pairs", help="Two ideal parts at a time, too.")] = True,
    as_json: Json = False,
) -> None:
    """Make each part of a run's machine ideal in turn and print what that is worth, the most first."""
    from archsim.cli.whatif import whatif

    whatif(run, overrides or [], out, jobs, (pairs, as_json))


@app.command("timeline")
@at_the_edge
def _timeline(
    run: Annotated[str, typer.Argument(metavar="RUN", help="A run's YAML file, or a packaged run's name.")],
    overrides: Overrides = None,
    phase: Annotated[str | None, typer.Option("--phase", metavar="PHASE")] = None,
    tasks: Annotated[
        str | None,
        typer.Option(
            "--tasks", metavar="FIRST:LAST", help="Play these tasks of irregular shadow mapping only."
        ),
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

    timeline(run, overrides or [], Wanted(phase, tasks, cycles, shown), out)


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


@sweep_app.command("run")
@at_the_edge
def _sweep_run(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A sweep's YAML file, or a packaged sweep's name.")
    ],
    out: Out = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, metavar="N", help="Processes.")] = 1,
    part: Annotated[
        str, typer.Option("--shard", metavar="I/N", help="Only part I of N, for batch systems.")
    ] = "1/1",
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Of a Dask cluster, instead of processes."),
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only print the points.")] = False,
) -> None:
    """Do what is not finished of a sweep (in runs/sweep-NAME unless --out is given)."""
    from archsim.cli.sweep import sweep

    sweep(file, out, (jobs, scheduler), part, dry_run)


SweepFolder = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a sweep.")]


@sweep_app.command("table")
@at_the_edge
def _sweep_table(
    folder: SweepFolder,
    form: Annotated[str, typer.Option("--format", metavar="text|csv|parquet")] = "text",
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Instead of stdout.")] = None,
) -> None:
    """Print or write the results of a sweep as one table."""
    from archsim.cli.sweep import show_table

    show_table(folder, form, out)


@sweep_app.command("pareto")
@at_the_edge
def _sweep_pareto(
    folder: SweepFolder,
    minimize: Annotated[
        list[str] | None,
        typer.Option("--minimize", metavar="COLUMN", help="Statistic or parameter. Repeatable."),
    ] = None,
) -> None:
    """Print the points that no other point beats, and the knee among them."""
    from archsim.cli.sweep import show_pareto

    show_pareto(folder, minimize or [])


@sweep_app.command("sensitivity")
@at_the_edge
def _sweep_sensitivity(
    folder: SweepFolder,
    metric: Annotated[str | None, typer.Option("--of", metavar="STATISTIC")] = None,
) -> None:
    """Print which parameter moves a statistic most."""
    from archsim.cli.sweep import show_sensitivity

    show_sensitivity(folder, metric)


@config_app.command("check")
@at_the_edge
def _config_check(
    files: Annotated[list[str], typer.Argument(metavar="FILE...")],
    overrides: Overrides = None,
) -> None:
    """Check runs, their parts, or sweeps; every problem is one line of file:line:column."""
    from archsim.cli.configs import check

    check(files, overrides or [])


@config_app.command("show")
@at_the_edge
def _config_show(
    file: Annotated[str, typer.Argument(metavar="FILE")],
    overrides: Overrides = None,
) -> None:
    """Print a run configuration fully resolved; it runs again as it is."""
    from archsim.cli.configs import show

    show(file, overrides or [])


@config_app.command("explain")
@at_the_edge
def _config_explain(
    key: Annotated[
        str, typer.Argument(metavar="KEY", help="A dotted path, e.g. machine.components.l2.size.")
    ],
    file: Annotated[str, typer.Argument(metavar="[FILE]", help="The run that it is looked up in.")] = "tiny",
    overrides: Overrides = None,
) -> None:
    """Explain one key: value, unit, default, who set it, range, meaning."""
    from archsim.cli.configs import print_explained

    print_explained(key, file, overrides or [])


@config_app.command("schema")
@at_the_edge
def _config_schema(
    part: Annotated[str, typer.Argument(metavar="[run|machine|scene|workload|sweep]")] = "run",
) -> None:
    """Print the JSON Schema of a configuration file, for completion and checks in an editor."""
    from archsim.cli.configs import print_schema

    print_schema(part)


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
    file: Annotated[str, typer.Argument(metavar="FILE", help="An assembly file, or a kernel's name.")],
) -> None:
    """Assemble a kernel and print its listing with static counts and live registers."""
    from archsim.cli.kernels import list_program

    list_program(file)


@app.command("disasm")
@at_the_edge
def _disasm(
    file: Annotated[str, typer.Argument(metavar="FILE", help="An assembly file, or a kernel's name.")],
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
