"""What reproducing a paper gives: simulated rows, cells, pictures."""

from __future__ import annotations

from typing import Any, NamedTuple

from archsim.reproduce.cells import Cell
from archsim.run.result import Check, Result


class Row(NamedTuple):
    """One simulated row of the tables."""

    config: Any  # the checked section that the row depends on
    result: Result
    wall_seconds: float


class Picture(NamedTuple):
    """A figure of the report."""

    caption: str
    html: str  # an <svg> or <img> element that needs nothing outside the page


class Reproduction(NamedTuple):
    """All rows that were simulated, all cells in the order of the tables, and pictures."""

    rows: dict[str, Row]
    cells: list[Cell]
    pictures: tuple[Picture, ...] = ()
    checks: tuple[Check, ...] = ()  # of what was simulated without being a row
