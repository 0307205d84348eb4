"""Plane encoding ([Ornstein05]): three constants of 40 bits at the rasterizer's precision. 120 bits, whatever
the tile's size.

A sample is the whole part of c0 + column cx + row cy. The rasterizer would hand the constants over; from a
finished buffer they have to be found: every sample's value leaves an interval for that sum, so every two
samples leave a strip of slopes (cx, cy).
"""

from __future__ import annotations

import numpy as np

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
    cx, cy = _slopes(_strips(tile, side), side)
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
def _slopes(strips, side):
    """Whole (cx, cy) nearest to where the strips leave most room; by ternary search, as that room is concave in cy."""
    low, high = -1e30, 1e30
    for distance in range(1, side):
        least, most = strips[0, distance + side]
        low, high = max(low, least / distance), min(high, most / distance)
    for _ in range(_SEARCH_STEPS):
        third = (high - low) / 3
        one, other = _room(strips, side, low + third), _room(strips, side, high - third)
        if one[1] - one[0] < other[1] - other[0]:
            low += third
        else:
            high -= third
    cy = _nearest((low + high) / 2)
    room = _room(strips, side, cy)
    return _nearest((room[0] + room[1]) / 2), cy


@njit
def _nearest(value):
    """The nearest whole number; 0 for what is far out of range."""
    return round(value) if abs(value) < 1e15 else 0


@njit
def _room(strips, side, cy):
    """(least, most) cx that all strips leave at a cy."""
    low, high = -1e30, 1e30
    for dx in range(1, side):
        for dy in range(1 - side, side):
            least, most = strips[dx, dy + side]
            low, high = max(low, (least - dy * cy) / dx), min(high, (most - dy * cy) / dx)
    return low, high


@njit
def _strips(tile, side):
    """(least, most) of dx cx + dy cy at [dx, dy + side], by all pairs of samples (dx, dy) apart: differences of whole
    parts are less than 1 from the sums' own."""
    strips = np.empty((side, 2 * side, 2))
    for dx in range(side):
        for dy in range(1 - side, side):
            least, most = -(1 << 62), 1 << 62
            for row in range(max(0, -dy), side - max(0, dy)):
                for column in range(side - dx):
                    change = tile[(row + dy) * side + column + dx] - tile[row * side + column]
                    least, most = max(least, (change - 1) * ONE + 1), min(most, (change + 1) * ONE - 1)
            strips[dx, dy + side, 0], strips[dx, dy + side, 1] = least, most
    return strips


@njit
def _constants(tile, side, cx, cy):
    """(least, most) c0 that gives every sample; an empty range if none does."""
    low, high = 0, (1 << WIDTH) - 1
    for row in range(side):
        for column in range(side):
            rest = tile[row * side + column] * ONE - column * cx - row * cy
            low, high = max(low, rest), min(high, rest + ONE - 1)
    return low, high
