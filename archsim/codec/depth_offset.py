"""Depth offset ([Morein]): each sample as an offset from the tile's least or from its greatest depth.

A bit says from which, and 3, 7 or 11 bits how far: 4, 8 or 12 bits a sample. The least and the greatest depth
are in the table that the z-cull unit keeps on chip, not among these bits.
"""

from __future__ import annotations

from archsim.codec.bits import get, put
from archsim.jit import njit

WIDTHS = (3, 7, 11)


@njit
def encode(tile, words):
    """Bits used by the narrowest width that does, or 0 if none does. `words` must be zero."""
    low, high = tile.min(), tile.max()
    farthest = 0
    for value in tile:
        farthest = max(farthest, min(value - low, high - value))
    for width in WIDTHS:
        if farthest < 1 << width:
            at = 0
            for value in tile:
                from_high = high - value < value - low
                at = put(words, at, int(from_high), 1)
                at = put(words, at, high - value if from_high else value - low, width)
            return at
    return 0


@njit
def decode(words, used, low, high, tile):
    """Write the tile that was encoded in `used` bits; `low` and `high` are its least and greatest depth."""
    width = used // len(tile) - 1
    for i in range(len(tile)):
        at = i * (width + 1)
        offset = get(words, at + 1, width)
        tile[i] = high - offset if get(words, at, 1) else low + offset
