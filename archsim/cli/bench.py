"""`archsim bench`."""

from __future__ import annotations

from rich import box
from rich.table import Table

from archsim.bench import measure
from archsim.cli.bars import Bars
from archsim.cli.console import terminal
from archsim.report.formats import number
from archsim.run.folder import as_json


def bench(json_only: bool) -> None:
    """Measure and print."""
    with Bars() as bars:
        rows = measure(progress=bars)
    if json_only:
        print(as_json([row._asdict() for row in rows]), end="")
        return

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("name")
    table.add_column("value", justify="right")
    table.add_column("unit")
    for row in rows:
        table.add_row(row.name, number(row.value), row.unit)
    terminal().print(table)
