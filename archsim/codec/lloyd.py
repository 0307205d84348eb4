"""The scheme of [Lloyd07] sec. 4.3: differences, then anchors, so that curvature in y is predicted too. 127
of 128 bits.

    column     0         1       2         3            D: down column 0;  X: to the left neighbour
    row 0      z0 24     d 3     dy0 6     d 3          row r, columns 1-3: X = a1 + dy_r + (column - 2) dx +
    d row 1      d 10      d 3     a1 16     dx 3         column 0:           D(1) = a0 - dy + d row 2      a0
    18     d 3     dy2 10    d 3                              D(2) = a0 row 3      dy 10     d 3     dy3 9
    d 3                              D(3) = a0 + dy

Fig. 5 leaves two things open, and both readings of each can be chosen: which end of y holds row 0 (the figure
has z0 at the bottom, the text upper left), and whether dy3 is an offset from the anchor's row, like the
others, or from row 2.
"""

from __future__ import annotations

from enum import IntEnum

from archsim.codec.bits import fits, get, get_signed, put
from archsim.jit import njit

SIDE = 4
USED_BITS = 127
DELTA = 3  # bits of dx and of corrections in columns 1 to 3
ROW_BITS = (6, 0, 10, 9)  # of dy_r; row 1 holds the anchor


class FirstRow(IntEnum):
    """Which of the tile's rows holds z0."""

    NEAR = 0  # the one at the least y', where the viewer is
    FAR = 1  # the one at the greatest y'


class LastDelta(IntEnum):
    """What row 3's dy is an offset from."""

    ANCHOR = 0  # the anchor a1
    ROW_2 = 1  # row 2's a1 + dy2


@njit
def encode(tile, first_row, last_delta, words):
    """Bits used, or 0 if a field overflows. `words` must be zero."""
    base = tile[_at(0, 0, first_row)]
    step1, step2, step3 = _down(tile, 1, first_row), _down(tile, 2, first_row), _down(tile, 3, first_row)
    bend = step3 - step2
    first_correction = step1 - (step2 - bend)
    anchor, right = _across(tile, 1, 2, first_row), _across(tile, 1, 3, first_row)
    tilt = right - anchor
    if not (fits(step2, 18) and fits(bend, 10) and fits(first_correction, 10)):
        return 0
    if not (fits(anchor, 16) and fits(tilt, DELTA)):
        return 0
    at = put(words, 0, base, 24)
    at = put(words, at, step2, 18)
    at = put(words, at, bend, 10)
    at = put(words, at, first_correction, 10)
    at = put(words, at, anchor, 16)
    at = put(words, at, tilt, DELTA)
    above = 0
    for row in range(SIDE):
        offset = _across(tile, row, 2, first_row) - anchor
        stored = offset - above if row == 3 and last_delta == LastDelta.ROW_2 else offset
        above = offset
        if row != 1:
            if not fits(stored, ROW_BITS[row]):
                return 0
            at = put(words, at, stored, ROW_BITS[row])
        for column in (1, 3):
            if row == 1 and column == 3:
                continue
            predicted = anchor + offset + (column - 2) * tilt
            correction = _across(tile, row, column, first_row) - predicted
            if not fits(correction, DELTA):
                return 0
            at = put(words, at, correction, DELTA)
    return at


@njit
def decode(words, first_row, last_delta, tile):
    """Write the tile that was encoded."""
    step2, bend = get_signed(words, 24, 18), get_signed(words, 42, 10)
    first_correction = get_signed(words, 52, 10)
    anchor, tilt = get_signed(words, 62, 16), get_signed(words, 78, DELTA)
    tile[_at(0, 0, first_row)] = get(words, 0, 24)
    steps = (0, step2 - bend + first_correction, step2, step2 + bend)
    at = 81
    above = 0
    for row in range(SIDE):
        if row > 0:
            tile[_at(row, 0, first_row)] = tile[_at(row - 1, 0, first_row)] + steps[row]
        offset = 0
        if row != 1:
            offset = get_signed(words, at, ROW_BITS[row])
            at += ROW_BITS[row]
            if row == 3 and last_delta == LastDelta.ROW_2:
                offset += above
        above = offset
        left = get_signed(words, at, DELTA)
        at += DELTA
        right = 0
        if row != 1:
            right = get_signed(words, at, DELTA)
            at += DELTA
        for column in range(1, SIDE):
            correction = left if column == 1 else right if column == 3 else 0
            change = anchor + offset + (column - 2) * tilt + correction
            tile[_at(row, column, first_row)] = tile[_at(row, column - 1, first_row)] + change


@njit
def _at(row, column, first_row):
    """The place in the tile, row 0 at the least y', of the figure's row and column."""
    return (SIDE - 1 - row if first_row == FirstRow.FAR else row) * SIDE + column


@njit
def _down(tile, row, first_row):
    return tile[_at(row, 0, first_row)] - tile[_at(row - 1, 0, first_row)]


@njit
def _across(tile, row, column, first_row):
    return tile[_at(row, column, first_row)] - tile[_at(row, column - 1, first_row)]
