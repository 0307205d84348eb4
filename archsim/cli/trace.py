"""`archsim trace`: address traces that other simulators read and write."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from archsim.cli.edge import at_the_edge

trace_app = typer.Typer(
    name="trace",
    help="Address traces: the formats of Dinero, Ramulator and DRAMsim3, and CSV.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

TraceFile = Annotated[Path, typer.Argument(metavar="FILE", help="An address trace; .gz is read too.")]
FormatName = Annotated[
    str,
    typer.Option("--format", metavar="NAME", help="dinero, xdin, ramulator, ramulator2, dramsim3 or csv."),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON to stdout and nothing else.")]


@trace_app.command("info")
@at_the_edge
def _info(file: TraceFile, form: FormatName, as_json: Json = False) -> None:
    """Count a trace's accesses, bytes and footprint."""
    from archsim.cli.address_trace import info

    info(file, form, as_json)
