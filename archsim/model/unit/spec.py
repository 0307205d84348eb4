"""An in-order fixed-function stage: what it is."""

from typing import NamedTuple


class UnitSpec(NamedTuple):
    """A stage that hands out one item every `interval_cycles`; 0 means that an item is always there (ideal)."""

    interval_cycles: int
