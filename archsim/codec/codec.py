"""All codecs behind one pair of functions: `encode` to bits and back, and the bits that memory then holds.

A tile is int64 [side x side], row after row, of depths 0 ... 2^24 - 1; row 0 is that of the least y'.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.codec import anchor, depth_offset, lloyd, plane, planes
from archsim.codec.lloyd import FirstRow, LastDelta
from archsim.codec.planes import Steps
from archsim.errors import fail
from archsim.jit import njit

DEPTH_BITS = 24
NUM_WORDS = 72  # room for the longest attempt of 8 x 8 samples


class Codec(IntEnum):
    """A compression scheme; each is a file beside this one."""

    NONE = 0
    LLOYD = 1
    ANCHOR = 2
    DDPCM = 3  # one plane
    DDPCM_TWO_PLANES = 4  # one plane, else two
    PLANE = 5
    HASSELGREN = 6  # one plane
    HASSELGREN_TWO_PLANES = 7  # one plane, else two
    DEPTH_OFFSET = 8


ONLY_4X4 = (Codec.LLOYD, Codec.ANCHOR)


class CodecSpec(NamedTuple):
    """A codec for tiles of one size."""

    codec: int  # Codec
    side: int  # samples along each side of a tile: 4 or 8
    granularity_bits: int  # memory holds multiples of this
    first_row: int  # FirstRow, for LLOYD
    last_delta: int  # LastDelta, for LLOYD


def make_codec(
    codec: Codec,
    side: int = 4,
    granularity_bits: int = 64,
    first_row: FirstRow = FirstRow.NEAR,
    last_delta: LastDelta = LastDelta.ANCHOR,
) -> CodecSpec:
    """A CodecSpec; raises ArchsimError for what is not defined."""
    if side not in (4, 8) or (codec in ONLY_4X4 and side != 4):
        raise fail(f"codec {codec.name.lower()} is not defined for tiles of {side} x {side}")
    if not 1 <= granularity_bits <= DEPTH_BITS * side * side:
        raise fail(f"a granularity of {granularity_bits} bits is not between 1 and a tile's size")
    return CodecSpec(int(codec), side, granularity_bits, int(first_row), int(last_delta))


@njit
def encode(spec, tile, words):
    """Encode into `words`, int64 [NUM_WORDS]; returns the bits used, or 0 where the tile has to stay as it
    is.
    """
    words[:] = 0
    codec, side = spec.codec, spec.side
    if codec == Codec.LLOYD:
        return lloyd.encode(tile, spec.first_row, spec.last_delta, words)
    if codec == Codec.ANCHOR:
        return anchor.encode(tile, words)
    if codec == Codec.PLANE:
        return plane.encode(tile, side, words)
    if codec == Codec.DEPTH_OFFSET:
        return depth_offset.encode(tile, words)
    if codec == Codec.NONE:
        return 0
    steps = Steps.HASSELGREN if codec >= Codec.HASSELGREN else Steps.DDPCM
    used = planes.encode_one(tile, side, steps, words)
    if used == 0 and codec in (Codec.DDPCM_TWO_PLANES, Codec.HASSELGREN_TWO_PLANES):
        used = planes.encode_two(tile, side, steps, words)
    return used


@njit
def decode(spec, words, used, low, high, tile):
    """Write the tile that `encode` put into `used` > 0 bits; `low` and `high` are its least and greatest
    depth.

    `used` stands for the tile's state in the on-chip table: which of a codec's modes it is in.
    """
    codec, side = spec.codec, spec.side
    if codec == Codec.LLOYD:
        lloyd.decode(words, spec.first_row, spec.last_delta, tile)
    elif codec == Codec.ANCHOR:
        anchor.decode(words, tile)
    elif codec == Codec.PLANE:
        plane.decode(words, side, tile)
    elif codec == Codec.DEPTH_OFFSET:
        depth_offset.decode(words, used, low, high, tile)
    else:
        steps = Steps.HASSELGREN if codec >= Codec.HASSELGREN else Steps.DDPCM
        if used == one_plane_bits(side, steps):
            planes.decode_one(words, side, steps, tile)
        else:
            planes.decode_two(words, side, steps, tile)


@njit
def one_plane_bits(side, steps):
    """What one plane always takes; two planes always take more."""
    samples = side * side
    return 24 + 50 + (samples - 1 if steps == Steps.HASSELGREN else 2 * (samples - 3))


@njit
def stored_bits(spec, used):
    """What memory holds for a tile encoded in `used` bits: whole units, and never more than the plain tile."""
    raw = DEPTH_BITS * spec.side * spec.side
    if used == 0:
        return raw
    return min(raw, -(-used // spec.granularity_bits) * spec.granularity_bits)


@njit
def tile_bits(spec, depth, wanted):
    """Bits that memory holds for each tile of a buffer, int64 [tile rows, tile columns]; 0 where not
    `wanted`.
    """
    side = spec.side
    bits = np.zeros(wanted.shape, np.int64)
    tile, words = np.empty(side * side, np.int64), np.empty(NUM_WORDS, np.int64)
    for row in range(wanted.shape[0]):
        for column in range(wanted.shape[1]):
            if wanted[row, column]:
                load_tile(depth, row, column, side, tile)
                bits[row, column] = stored_bits(spec, encode(spec, tile, words))
    return bits


@njit
def load_tile(depth, row, column, side, tile):
    """Copy a tile out of a buffer."""
    for i in range(side):
        for k in range(side):
            tile[i * side + k] = depth[row * side + i, column * side + k]
