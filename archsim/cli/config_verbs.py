"""`archsim config` and its verbs."""

from __future__ import annotations

from typing import Annotated

import typer

from archsim.cli.edge import at_the_edge
from archsim.cli.options import Overrides

config_app = typer.Typer(
    name="config", help="Check, show and explain configurations.", no_args_is_help=True, rich_markup_mode=None
)


@config_app.command("check")
@at_the_edge
def _config_check(
    files: Annotated[list[str], typer.Argument(metavar="FILE...")],
    overrides: Overrides = None,
) -> None:
    """Check runs, their parts, sweeps or walkthroughs; every problem is one line of file:line:column."""
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
    part: Annotated[str, typer.Argument(metavar="[run|machine|scene|workload|sweep|walkthrough]")] = "run",
) -> None:
    """Print the JSON Schema of a configuration file, for completion and checks in an editor."""
    from archsim.cli.configs import print_schema

    print_schema(part)
