"""DDPCM ([DeRoo02]): differences of differences, which are tiny on a plane. One plane: 24 + 2 x 25 + 2 (n -
3) bits.

The first sample, the slope along its row and that down its column; every further sample changes the slope
that led to its neighbour by 2 bits in two's complement. With two planes (`two_planes.py`) each starts from
its corner.
"""

from __future__ import annotations

from archsim.codec.bits import fits, get, get_signed, put
from archsim.jit import njit

SLOPE, CHANGE = 25, 2


@njit
def reach(view, side, rows):
    """Set `rows` [side] to how many samples of each column, from the top, the plane of the top left corner
    can have.
    """
    rows[:] = 0
    across = view[1] - view[0]
    first_down = view[side] - view[0]
    for column in range(side):
        if column >= 2:
            step = view[column] - view[column - 1]
            if not fits(step - across, CHANGE):
                break
            across = step
        rows[column] = 1
        down = first_down
        for row in range(1, side):
            step = view[row * side + column] - view[(row - 1) * side + column]
            if not fits(step - down, CHANGE):
                break
            down = step
            if row == 1:
                first_down = step
            rows[column] = row + 1


@njit
def encode_part(view, side, rows, words, at):
    """Write the samples that `rows` leaves to this corner; the next position, or 0 if a change overflows."""
    at = put(words, at, view[0], 24)
    across = view[1] - view[0]
    first_down = view[side] - view[0]
    at = put(words, put(words, at, across, SLOPE), first_down, SLOPE)
    for column in range(side):
        if rows[column] == 0:
            break
        if column >= 2:
            step = view[column] - view[column - 1]
            if not fits(step - across, CHANGE):
                return 0
            at = put(words, at, step - across, CHANGE)
            across = step
        down = first_down
        for row in range(1, rows[column]):
            step = view[row * side + column] - view[(row - 1) * side + column]
            if column + row > 1:
                if not fits(step - down, CHANGE):
                    return 0
                at = put(words, at, step - down, CHANGE)
            down = step
            if row == 1:
                first_down = step
    return at


@njit
def decode_part(words, at, side, rows, view):
    """Read what `encode_part` wrote; the next position."""
    view[0] = get(words, at, 24)
    across, first_down = get_signed(words, at + 24, SLOPE), get_signed(words, at + 24 + SLOPE, SLOPE)
    at += 24 + 2 * SLOPE
    for column in range(side):
        if rows[column] == 0:
            break
        if column >= 2:
            across += get_signed(words, at, CHANGE)
            at += CHANGE
        if column >= 1:
            view[column] = view[column - 1] + across
        down = first_down
        for row in range(1, rows[column]):
            if column + row > 1:
                down += get_signed(words, at, CHANGE)
                at += CHANGE
            view[row * side + column] = view[(row - 1) * side + column] + down
            if row == 1:
                first_down = down
    return at
