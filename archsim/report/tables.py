"""A paper's cells arranged as its tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from archsim.reproduce.cells import Cell, Paper

MOST_GROUPS = 4  # rows of a paper's table that fit beside each other with printed, ours and error
GOOD_PERCENT, FAIR_PERCENT = 5.0, 15.0  # largest errors of the first two grades


class Line(NamedTuple):
    """A column of the paper's table; one for each kind where its cells are of several."""

    column: str
    unit: str
    kind: str
    cells: list[Cell | None]  # one for each row of the paper's table


class TableView(NamedTuple):
    """A table, turned: a line for each of the paper's columns."""

    number: int
    title: str
    rows: list[str]  # the paper's rows
    lines: list[Line]
    notes: list[str]

    @property
    def is_wide(self) -> bool:
        """Whether three columns for each of the paper's rows are more than a page is wide."""
        return len(self.rows) > MOST_GROUPS

    @property
    def is_new(self) -> bool:
        """Whether the paper printed none of it, so that only our numbers are shown."""
        return all(cell is None or cell.printed is None for line in self.lines for cell in line.cells)


def tables(paper: Paper, cells: Sequence[Cell]) -> list[TableView]:
    """The cells arranged as the paper's tables."""
    views = []
    for number, title in paper.tables.items():
        own = [cell for cell in cells if cell.table == number]
        rows = list(dict.fromkeys(cell.row for cell in own))
        keys = dict.fromkeys((cell.column, cell.unit, cell.kind) for cell in own)
        lines = [Line(*key, [_find(own, row, key) for row in rows]) for key in keys]
        views.append(TableView(number, title, rows, lines, paper.notes.get(number, [])))
    return views


def _find(cells: Sequence[Cell], row: str, key: tuple[str, str, str]) -> Cell | None:
    return next(
        (cell for cell in cells if cell.row == row and (cell.column, cell.unit, cell.kind) == key), None
    )


def grade(error: float | None) -> str:
    """The colour class of an error."""
    if error is None:
        return "none"
    size = abs(error)
    return "good" if size <= GOOD_PERCENT else "fair" if size <= FAIR_PERCENT else "poor"
