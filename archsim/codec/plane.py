"""Plane encoding ([Ornstein05]): three constants of 40 bits at the rasterizer's precision. 120 bits, whatever
the tile's size.

A sample is the whole part of c0 + column cx + row cy. The rasterizer would hand the constants over; from a
finished buffer they have to be found: every sample's value leaves an interval for that sum, so every two
samples leave a strip of slopes (cx, cy).
"""

from __future__ import annotations

from archsim.codec.bits import fits, get, get_signed, put
from archsim.jit import njit

WIDTH = 40
FRACTION = 16
ONE = 1 << FRACTION
_SEARCH_STEPS = 48


@njit
def encode(tile, side, words):
    """Bits used, or 0 if no plane gives these samples. `words` must be zero."""
    if not _may_be_planar(tile, side):
        return 0
    cx, cy = _slopes(tile, side)
    low, high = _constants(tile, side, cx, cy)
    if low > high or not (fits(cx, WIDTH) and fits(cy, WIDTH)):
        return 0
    return put(words, put(words, put(words, 0, low, WIDTH), cx, WIDTH), cy, WIDTH)


@njit
def decode(words, side, tile):
    """Write the tile that was encoded."""
    constant = get(words, 0, WIDTH)
    cx, cy = get_signed(words, WIDTH, WIDTH), get_signed(words, 2 * WIDTH, WIDTH)
    for row in range(side):
        for column in range(side):
            tile[row * side + column] = (constant + column * cx + row * cy) >> FRACTION


@njit
def _may_be_planar(tile, side):
    """Whether second differences are as small as rounding makes them: in quick and most tiles out."""
    for row in range(side):
        for column in range(2, side):
            here = row * side + column
            if abs(tile[here] - 2 * tile[here - 1] + tile[here - 2]) > 1:
                return False
            there = column * side + row
            if abs(tile[there] - 2 * tile[there - side] + tile[there - 2 * side]) > 1:
                return False
    return True


@njit
def _slopes(tile, side):
    """Whole (cx, cy) nearest to where the strips leave most room; by ternary search, as that room is concave
    in cy.
    """
    low, high = -1e30, 1e30
    for distance in range(1, side):
        least, most = _strip(tile, side, 0, distance)
        low, high = max(low, least / distance), min(high, most / distance)
    for _ in range(_SEARCH_STEPS):
        third = (high - low) / 3
        one, other = _room(tile, side, low + third), _room(tile, side, high - third)
        if one[1] - one[0] < other[1] - other[0]:
            low += third
        else:
            high -= third
    cy = _nearest((low + high) / 2)
    room = _room(tile, side, cy)
    return _nearest((room[0] + room[1]) / 2), cy


@njit
def _nearest(value):
    """The nearest whole number; 0 for what is far out of range."""
    return round(value) if abs(value) < 1e15 else 0


@njit
def _room(tile, side, cy):
    """(least, most) cx that all strips leave at a cy."""
    low, high = -1e30, 1e30
    for dx in range(1, side):
        for dy in range(1 - side, side):
            least, most = _strip(tile, side, dx, dy)
            low, high = max(low, (least - dy * cy) / dx), min(high, (most - dy * cy) / dx)
    return low, high


@njit
def _strip(tile, side, dx, dy):
    """(least, most) of dx cx + dy cy, by all pairs of samples (dx, dy) apart: differences change by less than
    1.
    """
    least, most = -(1 << 62), 1 << 62
    for row in range(max(0, -dy), side - max(0, dy)):
        for column in range(side - dx):
            change = tile[(row + dy) * side + column + dx] - tile[row * side + column]
            least, most = max(least, (change - 1) * ONE + 1), min(most, (change + 1) * ONE - 1)
    return least, most


@njit
def _constants(tile, side, cx, cy):
    """(least, most) c0 that gives every sample; an empty range if none does."""
    low, high = 0, (1 << WIDTH) - 1
    for row in range(side):
        for column in range(side):
            rest = tile[row * side + column] * ONE - column * cx - row * cy
            low, high = max(low, rest), min(high, rest + ONE - 1)
    return low, high
