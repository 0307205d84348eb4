"""What reproducing a paper gives: simulated rows, cells, pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from archsim.config import Loaded
from archsim.config.explain import Origin
from archsim.reproduce.cells import Cell
from archsim.run.result import Check, Result


class Row(NamedTuple):
    """One simulated row of the tables."""

    loaded: Loaded[Any]  # the checked section that the row depends on
    result: Result
    wall_seconds: float

    @property
    def config(self) -> Any:
        return self.loaded.config


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
    origins: Mapping[str, Sequence[Origin]] = {}  # by title: the configuration of that
