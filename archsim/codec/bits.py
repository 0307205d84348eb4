"""Fields of a compressed tile: whole numbers of a few bits, one after the other. Words hold 32 bits each, as
int64.
"""

from __future__ import annotations

from archsim.jit import njit

WORD = 32


@njit
def put(words, at, value, width):
    """Write the low `width` bits of a value from bit `at` on, into words that hold 0 there; the next
    position.
    """
    value &= (1 << width) - 1
    done = 0
    while done < width:
        place = (at + done) % WORD
        part = min(width - done, WORD - place)
        words[(at + done) // WORD] |= ((value >> done) & ((1 << part) - 1)) << place
        done += part
    return at + width


@njit
def get(words, at, width):
    """The number of `width` bits at bit `at`, not negative."""
    value = 0
    done = 0
    while done < width:
        place = (at + done) % WORD
        part = min(width - done, WORD - place)
        value |= ((words[(at + done) // WORD] >> place) & ((1 << part) - 1)) << done
        done += part
    return value


@njit
def get_signed(words, at, width):
    """The same in two's complement."""
    value = get(words, at, width)
    return value - (1 << width) if value >> (width - 1) else value


@njit
def fits(value, width):
    """Whether a value can be written in two's complement of `width` bits."""
    return -(1 << (width - 1)) <= value < 1 << (width - 1)


@njit
def is_close(value, low):
    """Whether a value is `low` or one more."""
    return 0 <= value - low <= 1
