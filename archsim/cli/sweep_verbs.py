"""`archsim sweep` and its verbs. Bodies import what they need, so that `--help` stays fast."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from archsim.cli.edge import at_the_edge
from archsim.cli.options import Jobs, Out


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


@sweep_app.command("run")
@at_the_edge
def _sweep_run(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A sweep's YAML file, or a packaged sweep's name.")
    ],
    out: Out = None,
    jobs: Jobs = 1,
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
