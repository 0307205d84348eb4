"""Where the samples of a shadow map lie: whole coordinates on a uniform grid fine enough to tell them apart.

A coordinate is a whole multiple of 2^-bits of the map's width or height. Columns are evenly spaced. Rows are
evenly spaced in y' = F(y), so that their y is G(y'), rounded to the grid. [Lloyd07] sec. 4.2, 4.2.3
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.lograster.parameterization import check_ratio, log_unwarp

TILE = 4  # samples along each side of a tile
BITS = 24  # the mantissa of a 32-bit float [Lloyd07] sec. 4.2.3
MOST_BITS = 26  # with GUARD, products in edge functions stay below 2^62
MOST_SAMPLES = 1 << 15  # along one side


class Grid(NamedTuple):
    """The samples of a map; sample (column, row) is at (x[column], y[row]) 2^-bits."""

    x: np.ndarray  # int64 [columns] rising
    y: np.ndarray  # int64 [rows] rising; equal neighbours where `bits` are too few for `ratio`
    bits: int
    ratio: float  # f/n of the logarithmic rows; 1: linear


def make_grid(columns: int, rows: int, ratio: float = 1.0, bits: int = BITS) -> Grid:
    """Samples at the centres of columns x rows texels."""
    check_ratio(ratio)
    for what, number in (("columns", columns), ("rows", rows)):
        if not 0 < number <= MOST_SAMPLES or number % TILE:
            raise fail(f"{what} of a map must be a multiple of {TILE} up to {MOST_SAMPLES}, not {number}")
    if not 1 <= bits <= MOST_BITS:
        raise fail(f"coordinates have 1 to {MOST_BITS} bits, not {bits}")
    scale = float(1 << bits)
    centres_x = (np.arange(columns) + 0.5) / columns
    centres_y = log_unwarp((np.arange(rows) + 0.5) / rows, ratio)
    return Grid(_snapped(centres_x, scale), _snapped(centres_y, scale), bits, float(ratio))


def lost_rows(grid: Grid) -> int:
    """Rows that fall on the row before them: above 0 where the precision does not suffice."""
    return int(np.count_nonzero(np.diff(grid.y) == 0))


def _snapped(positions: np.ndarray, scale: float) -> np.ndarray:
    return np.floor(positions * scale + 0.5).astype(np.int64)
