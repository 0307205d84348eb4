"""Anchor encoding ([VanDyke05]): a plane through an anchor sample and two neighbours predicts the other 13.
119 bits.

Anchor 24 bits, offsets to its neighbours 15 bits each, corrections 5 bits each.
"""

from __future__ import annotations

from archsim.codec.bits import fits, get, get_signed, put
from archsim.jit import njit

SIDE = 4
ANCHOR_ROW = ANCHOR_COLUMN = 1  # an inner sample: corrections grow with the distance from it
SLOPE, CORRECTION = 15, 5


@njit
def encode(tile, words):
    """Bits used, or 0 if a field overflows. `words` must be zero."""
    anchor = tile[ANCHOR_ROW * SIDE + ANCHOR_COLUMN]
    dx = tile[ANCHOR_ROW * SIDE + ANCHOR_COLUMN + 1] - anchor
    dy = tile[(ANCHOR_ROW + 1) * SIDE + ANCHOR_COLUMN] - anchor
    if not (fits(dx, SLOPE) and fits(dy, SLOPE)):
        return 0
    at = put(words, put(words, put(words, 0, anchor, 24), dx, SLOPE), dy, SLOPE)
    for row in range(SIDE):
        for column in range(SIDE):
            if not _spans_plane(row, column):
                correction = tile[row * SIDE + column] - _predicted(anchor, dx, dy, row, column)
                if not fits(correction, CORRECTION):
                    return 0
                at = put(words, at, correction, CORRECTION)
    return at


@njit
def decode(words, tile):
    """Write the tile that was encoded."""
    anchor = get(words, 0, 24)
    dx, dy = get_signed(words, 24, SLOPE), get_signed(words, 24 + SLOPE, SLOPE)
    at = 24 + 2 * SLOPE
    for row in range(SIDE):
        for column in range(SIDE):
            tile[row * SIDE + column] = _predicted(anchor, dx, dy, row, column)
            if not _spans_plane(row, column):
                tile[row * SIDE + column] += get_signed(words, at, CORRECTION)
                at += CORRECTION


@njit
def _spans_plane(row, column):
    """Whether a sample is the anchor or one of its two neighbours."""
    right = row == ANCHOR_ROW and column in (ANCHOR_COLUMN, ANCHOR_COLUMN + 1)
    return right or (row == ANCHOR_ROW + 1 and column == ANCHOR_COLUMN)


@njit
def _predicted(anchor, dx, dy, row, column):
    return anchor + (column - ANCHOR_COLUMN) * dx + (row - ANCHOR_ROW) * dy
