"""One or two planes in a tile, each predicted from its own corner, by the differences of `ddpcm` or
`hasselgren`.

    A A A B      With two planes, a bit says which two opposite corners; A is then that of the top row. For
    each column A A B B      (from A's side) a number says how many of its samples, from the top, belong to A;
    the rest are B's, A A B B      which is read from the other corner: last row first, last column first. A B
    B B
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from archsim.codec import ddpcm, hasselgren
from archsim.codec.bits import get, put
from archsim.jit import njit


class Steps(IntEnum):
    """How the samples of a plane follow from each other."""

    DDPCM = 0
    HASSELGREN = 1


@njit
def encode_one(tile, side, steps, words):
    """Bits used by one plane, or 0 if the tile is not one. `words` must be zero."""
    rows = np.empty(side, np.int64)
    for choice in range(_choices(steps)):
        _reach(tile, side, steps, choice, rows)
        if rows.min() == side:
            return _encode_part(tile, side, steps, choice, rows, words, 0)
    return 0


@njit
def decode_one(words, side, steps, tile):
    """Write the tile that was encoded."""
    _decode_part(words, 0, side, steps, np.full(side, side), tile)


@njit
def encode_two(tile, side, steps, words):
    """Bits used by two planes, or 0 if the tile is not made of two. `words` must be zero."""
    one, other = np.empty(side * side, np.int64), np.empty(side * side, np.int64)
    rows_one, rows_other = np.empty(side, np.int64), np.empty(side, np.int64)
    for mirrored in range(2):
        _turned(tile, side, mirrored == 1, False, one)
        _turned(tile, side, mirrored == 0, True, other)
        for choice in range(_choices(steps)):
            for other_choice in range(_choices(steps)):
                _reach(one, side, steps, choice, rows_one)
                _reach(other, side, steps, other_choice, rows_other)
                if not _share(rows_one, rows_other):
                    continue
                at = put(words, 0, mirrored, 1)
                for column in range(side):
                    at = put(words, at, rows_one[column], _count_bits(side))
                at = _encode_part(one, side, steps, choice, rows_one, words, at)
                if at:
                    at = _encode_part(other, side, steps, other_choice, rows_other, words, at)
                if at:
                    return at
                words[:] = 0
    return 0


@njit
def decode_two(words, side, steps, tile):
    """Write the tile that was encoded."""
    one, other = np.zeros(side * side, np.int64), np.zeros(side * side, np.int64)
    rows_one, rows_other = np.empty(side, np.int64), np.empty(side, np.int64)
    mirrored = get(words, 0, 1)
    at = 1
    for column in range(side):
        rows_one[column] = get(words, at, _count_bits(side))
        rows_other[side - 1 - column] = side - rows_one[column]
        at += _count_bits(side)
    at = _decode_part(words, at, side, steps, rows_one, one)
    _decode_part(words, at, side, steps, rows_other, other)
    for row in range(side):
        for column in range(side):
            place = row * side + (side - 1 - column if mirrored else column)
            mine = row < rows_one[column]
            tile[place] = one[row * side + column] if mine else other[-1 - (row * side + column)]


@njit
def _share(rows_one, rows_other):
    """Cut what both planes can have down to shares: the first gets what it can. False if a sample is left
    over.

    A plane's columns follow from each other, so none of its columns may be empty before one that is not.
    """
    side = len(rows_one)
    for column in range(side):
        if rows_one[column] + rows_other[side - 1 - column] < side:
            return False
    first = 0  # leftmost column of the other plane
    while first < side and rows_one[first] == side:
        first += 1
    for column in range(side):
        if column > first and rows_one[column] == side:
            rows_one[column] = side - 1
        rows_other[side - 1 - column] = side - rows_one[column]
    return first < side


@njit
def _turned(tile, side, left_right, upside_down, view):
    """Write the tile mirrored in either or both directions."""
    for row in range(side):
        for column in range(side):
            from_row = side - 1 - row if upside_down else row
            from_column = side - 1 - column if left_right else column
            view[row * side + column] = tile[from_row * side + from_column]


@njit
def _count_bits(side):
    """Bits of a number of samples of a column, 0 to side."""
    return 3 if side == 4 else 4


@njit
def _choices(steps):
    return hasselgren.CHOICES if steps == Steps.HASSELGREN else 1


@njit
def _reach(view, side, steps, choice, rows):
    if steps == Steps.HASSELGREN:
        hasselgren.reach(view, side, choice, rows)
    else:
        ddpcm.reach(view, side, rows)


@njit
def _encode_part(view, side, steps, choice, rows, words, at):
    if steps == Steps.HASSELGREN:
        return hasselgren.encode_part(view, side, choice, rows, words, at)
    return ddpcm.encode_part(view, side, rows, words, at)


@njit
def _decode_part(words, at, side, steps, rows, view):
    if steps == Steps.HASSELGREN:
        return hasselgren.decode_part(words, at, side, rows, view)
    return ddpcm.decode_part(words, at, side, rows, view)
