"""`archsim diff`."""

from __future__ import annotations

from pathlib import Path

import typer
from rich import box
from rich.console import Console
from rich.table import Table

from archsim.cli.edge import FAILED_CHECK
from archsim.report.differences import Differences, differences
from archsim.report.formats import number, percent, setting
from archsim.run.folder import as_json, load_folder


def diff(left: Path, right: Path, tolerance_percent: float, limit: int, json_only: bool) -> None:
    """Print in what two runs differ. Exit code 1 if their results do by more than the tolerance."""
    found = differences(load_folder(left), load_folder(right))
    if json_only:
        print(as_json(_plain(found)), end="")
    else:
        _print(found, (str(left), str(right)), limit)
    if found.matter(tolerance_percent):
        raise typer.Exit(FAILED_CHECK)


def _print(found: Differences, names: tuple[str, str], limit: int) -> None:
    console = Console()
    if found.config:
        table = _table("Configuration", "key", names)
        for key, left, right in found.config:
            table.add_row(key, setting(left), setting(right))
        console.print(table)
    if found.statistics:
        table = _table("Statistics, the largest change first", "statistic", names)
        table.add_column("change", justify="right")
        for change in found.statistics[: limit or None]:
            name = f"{change.name} [{change.unit}]"
            table.add_row(name, number(change.left), number(change.right), percent(change.percent))
        console.print(table)
        if limit and len(found.statistics) > limit:
            console.print(f"{len(found.statistics) - limit} more; --limit 0 shows all")
    for name, left, right in found.checks:
        console.print(f"check {name}: {number(left)} in {names[0]}, {number(right)} in {names[1]}")
    if found.num_pixels != 0:
        console.print(
            "the pictures have different sizes"
            if found.num_pixels is None
            else f"{found.num_pixels} pixels differ"
        )
    if not found.matter():
        console.print("the results are equal")


def _table(title: str, head: str, names: tuple[str, str]) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column(head, overflow="fold")
    for name in names:
        table.add_column(name, justify="right", overflow="fold")
    return table


def _plain(found: Differences) -> dict[str, object]:
    return {
        "config": [change._asdict() for change in found.config],
        "statistics": [change._asdict() for change in found.statistics],
        "checks": [list(change) for change in found.checks],
        "num_pixels": found.num_pixels,
    }
