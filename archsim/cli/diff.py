"""`archsim diff`."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import typer
from rich import box
from rich.table import Table

from archsim.cli.console import terminal
from archsim.cli.edge import FAILED_CHECK
from archsim.report.comparison_page import comparison_report
from archsim.report.differences import Differences, differences
from archsim.report.formats import number, percent, setting
from archsim.run.folder import as_json, load_folder, write_whole


class Shown(NamedTuple):
    """How the differences are shown."""

    limit: int  # statistics to print; 0: all
    as_json: bool
    page: Path | None  # to write, the images side by side


def diff(left: Path, right: Path, tolerance_percent: float, shown: Shown) -> None:
    """Print in what two runs differ. Exit code 1 if their results do by more than the tolerance."""
    runs = load_folder(left), load_folder(right)
    found = differences(*runs)
    if shown.page is not None:
        write_whole(shown.page, comparison_report(runs))
    if shown.as_json:
        print(as_json(_plain(found)), end="")
    else:
        _print(found, (str(left), str(right)), shown.limit)
        if shown.page is not None:
            print(f"written to {shown.page}")
    if found.matter(tolerance_percent):
        raise typer.Exit(FAILED_CHECK)


def _print(found: Differences, names: tuple[str, str], limit: int) -> None:
    console = terminal()
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
