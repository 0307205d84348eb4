"""A statistic before it has a value: its name, its unit, the sentence that defines it, and how it is computed.

Every statistic is one line of one table, so the reference (`archsim statistics`) cannot differ from the code.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from archsim.run.result import Statistic


class Measure(NamedTuple):
    """One line of a table of statistics."""

    name: str  # below the table's prefix; may hold names in braces, such as {level}
    unit: str
    definition: str  # one sentence; may hold the same names
    value: Callable[[Any], int | float | np.integer | np.floating]  # of the view that the table is about


Table = Sequence[Measure]


def measured(prefix: str, table: Table, view: Any, **names: str) -> list[Statistic]:
    """The statistics of a table for one view, each named `prefix.name`; `names` fill the braces."""
    return [
        Statistic(
            f"{prefix}.{measure.name.format(**names)}",
            _number(measure.value(view)),
            measure.unit,
            measure.definition.format(**names),
        )
        for measure in table
    ]


def ratio(part: float, whole: float) -> float:
    """part / whole, 0 when there is no whole."""
    return float(part) / float(whole) if whole else 0.0


def percent(part: float, whole: float) -> float:
    """Share of the whole in per cent, 0 when there is no whole."""
    return 100.0 * ratio(part, whole)


def _number(value: Any) -> int | float:
    return int(value) if isinstance(value, int | np.integer) else float(value)
