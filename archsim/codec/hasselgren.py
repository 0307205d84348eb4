"""The scheme of [Hasselgren06]: a rounded plane's steps take two neighbouring values, so one bit says which.
24 + 2 x 25 + n - 1 bits.

The first sample, the lesser step along its row and the lesser step down any column; one bit for every further
sample. With two planes (`two_planes.py`) each starts from its corner. `choice` says which of its first steps
are the greater one.
"""

from __future__ import annotations

from archsim.codec.bits import get, get_signed, is_close, put
from archsim.jit import njit

SLOPE = 25
CHOICES = 4


@njit
def steps(view, side, choice):
    """(lesser step across, lesser step down) of a plane through the corner: its first steps, less 1 by
    `choice`.
    """
    return view[1] - view[0] - (choice & 1), view[side] - view[0] - (choice >> 1)


@njit
def reach(view, side, choice, rows):
    """Set `rows` [side] to how many samples of each column, from the top, the plane of the top left corner
    can have.
    """
    across, down = steps(view, side, choice)
    rows[:] = 0
    for column in range(side):
        if column > 0 and not is_close(view[column] - view[column - 1], across):
            return
        rows[column] = 1
        for row in range(1, side):
            if not is_close(view[row * side + column] - view[(row - 1) * side + column], down):
                break
            rows[column] = row + 1


@njit
def encode_part(view, side, choice, rows, words, at):
    """Write the samples that `rows` leaves to this corner, which `reach` has to allow; the next position."""
    across, down = steps(view, side, choice)
    at = put(words, put(words, put(words, at, view[0], 24), across, SLOPE), down, SLOPE)
    for column in range(side):
        if rows[column] == 0:
            break
        if column > 0:
            at = put(words, at, view[column] - view[column - 1] - across, 1)
        for row in range(1, rows[column]):
            at = put(words, at, view[row * side + column] - view[(row - 1) * side + column] - down, 1)
    return at


@njit
def decode_part(words, at, side, rows, view):
    """Read what `encode_part` wrote; the next position."""
    view[0] = get(words, at, 24)
    across, down = get_signed(words, at + 24, SLOPE), get_signed(words, at + 24 + SLOPE, SLOPE)
    at += 24 + 2 * SLOPE
    for column in range(side):
        if rows[column] == 0:
            break
        if column > 0:
            view[column] = view[column - 1] + across + get(words, at, 1)
            at += 1
        for row in range(1, rows[column]):
            view[row * side + column] = view[(row - 1) * side + column] + down + get(words, at, 1)
            at += 1
    return at
