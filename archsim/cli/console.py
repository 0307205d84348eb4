"""How numbers and run summaries look on a terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

from archsim.run.result import Result


def number(value: Any) -> str:
    """A value for people: whole numbers with separators, others with four significant digits."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return "-" if value is None else str(value)
    if isinstance(value, list | tuple):
        return " - ".join(number(item) for item in value)
    if isinstance(value, int) or float(value).is_integer():
        return f"{int(value):,}"
    return f"{value:,.0f}" if abs(value) >= 10_000 else f"{value:.4g}"


def print_summary(result: Result) -> None:
    """The headline numbers on stdout."""
    table = Table(title=result.name, title_justify="left", show_header=False, pad_edge=False, box=None)
    table.add_column(overflow="fold")
    table.add_column(justify="right", overflow="fold")
    for name, value in result.summary.items():
        table.add_row(name.replace("_", " "), number(value))
    Console().print(table)
