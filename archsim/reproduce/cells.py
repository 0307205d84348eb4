"""A cell of a paper's table: what is printed, what we get, and what kind of comparison that is."""

from __future__ import annotations

from typing import NamedTuple

EXACT, CALIBRATED, PREDICTED = "exact", "calibrated", "predicted"
NOT_COMPARABLE, NOT_PRINTED = "not comparable", "not printed"

KINDS = {
    EXACT: "a size or formula; has to be equal",
    CALIBRATED: "a stand-in scene, or a reading that the paper leaves open, was chosen to come near it",
    PREDICTED: "comes out of the simulated machine; the notes say what was chosen knowing it",
    NOT_COMPARABLE: "defined in another way than ours; see the note",
    NOT_PRINTED: "the paper gives no number, or only a curve",
}

Printed = int | float | list[int] | list[float]


class Cell(NamedTuple):
    """One number of a paper beside ours."""

    paper: str
    table: int
    row: str
    column: str
    kind: str  # one of KINDS
    printed: Printed | None  # a number, or the [lowest, highest] of a printed range; None: not printed
    ours: int | float
    unit: str
    error_percent: float | None  # ours against printed, signed; None where there is no comparison


class Paper(NamedTuple):
    """What is said about the paper itself."""

    id: str
    title: str
    tables: dict[int, str]  # table -> what it is about
    notes: dict[int, list[str]]  # table -> remarks on its cells


class Place(NamedTuple):
    """Where a cell stands."""

    paper: str
    table: int
    row: str
    column: str


def make_cell(place: Place, kind: str, printed: Printed, ours: int | float, unit: str) -> Cell:
    """A cell with its error, unless it can't be compared."""
    error = None if kind == NOT_COMPARABLE else error_percent(printed, ours)
    return Cell(*place, kind, printed, ours, unit, error)


def new_cell(place: Place, ours: int | float, unit: str) -> Cell:
    """A cell of a table that the paper never printed."""
    return Cell(*place, NOT_PRINTED, None, ours, unit, None)


def error_percent(printed: Printed, ours: int | float) -> float | None:
    """100 (ours - printed) / printed, 0 inside a printed range; None where printed is 0."""
    low, high = (printed[0], printed[-1]) if isinstance(printed, list) else (printed, printed)
    nearest = min(max(ours, low), high)
    if nearest == 0:
        return None
    return round(100.0 * (ours - nearest) / nearest, 4)
