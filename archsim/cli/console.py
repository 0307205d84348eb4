"""How a run's summary and a paper's tables look on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from archsim.report.formats import number, percent, words
from archsim.report.statistics import headlines
from archsim.report.tables import Line, TableView, grade
from archsim.reproduce.cells import Cell
from archsim.run.result import Result

_WIDE, _WIDE_ROW = (
    20,
    35,
)  # columns of a terminal that a table takes, and more for each of the paper's rows beside it
_COLOURS = {"good": "blue", "fair": "yellow", "poor": "red", "none": "dim"}


def terminal(stderr: bool = False) -> Console:
    """A console that prints text as it is: the [cycles] of a unit are no markup."""
    return Console(stderr=stderr, markup=False)


def print_summary(result: Result) -> None:
    """The headline numbers on stdout."""
    table = Table(title=result.name, title_justify="left", show_header=False, pad_edge=False, box=None)
    table.add_column()
    table.add_column(justify="right")
    table.add_column()
    for item in headlines(result):
        table.add_row(words(item.label), number(item.value), item.unit)
    terminal().print(table)


def print_tables(views: Sequence[TableView]) -> None:
    """A paper's tables on stdout: its rows side by side where the terminal is wide enough."""
    console = terminal()
    for view in views:
        title = f"Table {view.number}. {view.title}"
        wide = console.width >= _WIDE + _WIDE_ROW * len(view.rows)
        if view.is_new:
            table = _matrix(title, view)
        else:
            table = _wide_table(title, view) if wide else _long_table(title, view)
        console.print(table)
        for note in view.notes:
            console.print(note, style="dim")
        console.print()


def _wide_table(title: str, view: TableView) -> Table:
    """A line for each column of the paper's table, printed, ours and error for each of its rows."""
    table = _table(title)
    table.add_column("quantity")
    table.add_column("kind")
    for row in view.rows:
        table.add_column(f"{words(row)}\nprinted", justify="right")
        table.add_column("\nours", justify="right")
        table.add_column("\nerror", justify="right")
    for line in view.lines:
        parts = [part for cell in line.cells for part in _parts(cell)]
        table.add_row(_quantity(line), line.kind, *parts)
    return table


def _long_table(title: str, view: TableView) -> Table:
    """A line for each cell, the paper's rows one after the other."""
    table = _table(title)
    table.add_column("quantity")
    for head in ("printed", "ours", "error"):
        table.add_column(head, justify="right")
    table.add_column("kind")
    for index, row in enumerate(view.rows):
        table.add_section()
        table.add_row(Text(words(row), style="bold"))
        for line in view.lines:
            cell = line.cells[index]
            if cell is not None:
                table.add_row(Text("  ") + _quantity(line), *_parts(cell), cell.kind)
    return table


def _matrix(title: str, view: TableView) -> Table:
    """Our numbers alone: a line for each row, a column for each quantity."""
    table = _table(title)
    table.add_column("")
    for line in view.lines:
        unit = f"\n[{line.unit}]" if line.unit else ""
        table.add_column(words(line.column) + unit, justify="right", overflow="fold")
    for index, row in enumerate(view.rows):
        cells = [line.cells[index] for line in view.lines]
        table.add_row(words(row), *("" if cell is None else number(cell.ours) for cell in cells))
    return table


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)


def _quantity(line: Line) -> Text:
    return Text(f"{words(line.column)} [{line.unit}]" if line.unit else words(line.column))


def _parts(cell: Cell | None) -> tuple[str, str, Text]:
    """Printed, ours and error of a cell."""
    if cell is None:
        return "", "", Text("")
    error = Text(percent(cell.error_percent), style=_COLOURS[grade(cell.error_percent)])
    printed = "" if cell.printed is None else number(cell.printed)
    return printed, number(cell.ours), error
