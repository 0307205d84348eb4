"""A paper's cells arranged as its tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from archsim.reproduce.cells import Cell, Paper

GOOD_PERCENT, FAIR_PERCENT = 5.0, 15.0  # largest errors of the first two grades


class Line(NamedTuple):
    """A column of the paper's table."""

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


def tables(paper: Paper, cells: Sequence[Cell]) -> list[TableView]:
    """The cells arranged as the paper's tables, turned: a line for each of its columns."""
    views = []
    for number, title in paper.tables.items():
        own = [cell for cell in cells if cell.table == number]
        rows = list(dict.fromkeys(cell.row for cell in own))
        lines = []
        for column in dict.fromkeys(cell.column for cell in own):
            found = {cell.row: cell for cell in own if cell.column == column}
            any_cell = next(iter(found.values()))
            kinds = list(dict.fromkeys(cell.kind for cell in found.values()))
            lines.append(Line(column, any_cell.unit, ", ".join(kinds), [found.get(row) for row in rows]))
        views.append(TableView(number, title, rows, lines, paper.notes.get(number, [])))
    return views


def grade(error: float | None) -> str:
    """The colour class of an error."""
    if error is None:
        return "none"
    size = abs(error)
    return "good" if size <= GOOD_PERCENT else "fair" if size <= FAIR_PERCENT else "poor"
