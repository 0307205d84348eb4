"""The on-chip side of the depth buffer: a cache of whole blocks, and the table of what memory holds for each.

A block is what the codec compresses: a tile, or 2 x 2 tiles for codecs of 8 x 8 samples. The pipeline tests
tiles in order, so which blocks are in the cache, and how well each compresses when it leaves, does not depend
on time. Partly drawn blocks go to memory as they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.codec.codec import NUM_WORDS, Codec, CodecSpec, encode, load_tile, make_codec, stored_bits
from archsim.codec.lloyd import FirstRow, LastDelta
from archsim.config.tiles import TileCacheConfig
from archsim.jit import njit
from archsim.lograster.depth_buffer import FARTHEST
from archsim.lograster.grid import TILE

NOWHERE = -1


class ZCacheSpec(NamedTuple):
    """A set-associative cache of blocks, least recently used first out."""

    num_sets: int
    num_ways: int


class ZState(NamedTuple):
    """The depth buffer, its tables and its cache."""

    depth: np.ndarray  # int32 [rows, columns] in whole blocks; samples beyond the map stay FARTHEST
    farthest: np.ndarray  # int32 [tiles] greatest depth of each tile: what z-cull compares with
    held_bytes: np.ndarray  # int64 [blocks] bytes that memory holds; 0: cleared, nothing to read
    tag: np.ndarray  # int64 [sets, ways] block, or NOWHERE
    last_use: np.ndarray  # int64 [sets, ways]
    dirty: np.ndarray  # bool [sets, ways]
    clock: np.ndarray  # int64 [1] look-ups so far
    moved: np.ndarray  # int64 [2] blocks read and written so far
    block: np.ndarray  # int64 [side x side] room for the codec
    words: np.ndarray  # int64 [NUM_WORDS] room for the codec


def cleared(rows: int, columns: int, cache: ZCacheSpec, side: int = TILE) -> ZState:
    """A cleared buffer in blocks of `side` x `side` samples, an empty cache."""
    block_rows, block_columns = -(-rows // side), -(-columns // side)
    return ZState(
        depth=np.full((block_rows * side, block_columns * side), FARTHEST, np.int32),
        farthest=np.full((rows // TILE) * (columns // TILE), FARTHEST, np.int32),
        held_bytes=np.zeros(block_rows * block_columns, np.int64),
        tag=np.full((cache.num_sets, cache.num_ways), NOWHERE, np.int64),
        last_use=np.zeros((cache.num_sets, cache.num_ways), np.int64),
        dirty=np.zeros((cache.num_sets, cache.num_ways), np.bool_),
        clock=np.zeros(1, np.int64),
        moved=np.zeros(2, np.int64),
        block=np.empty(side * side, np.int64),
        words=np.empty(NUM_WORDS, np.int64),
    )


@njit
def block_of(state, side, tile):
    """The number of the block that a tile (row, column) is part of."""
    return tile[0] * TILE // side * (state.depth.shape[1] // side) + tile[1] * TILE // side


@njit
def look_up(state, block):
    """Bring a block in: (its set, its way, was it there, the dirty block that has to leave or NOWHERE)."""
    here = block % len(state.tag)
    state.clock[0] += 1
    way = 0
    for each in range(state.tag.shape[1]):
        if state.tag[here, each] == block:
            state.last_use[here, each] = state.clock[0]
            return here, each, True, NOWHERE
        if state.last_use[here, each] < state.last_use[here, way]:
            way = each
    leaving = state.tag[here, way] if state.dirty[here, way] else NOWHERE
    state.tag[here, way] = block
    state.last_use[here, way] = state.clock[0]
    state.dirty[here, way] = False
    return here, way, False, leaving


@njit
def write_back(state, codec, block):
    """Compress a block as it is now; the bytes that memory then holds for it."""
    block_columns = state.depth.shape[1] // codec.side
    load_tile(state.depth, block // block_columns, block % block_columns, codec.side, state.block)
    used = encode(codec, state.block, state.words)
    state.held_bytes[block] = stored_bits(codec, used) // 8
    state.moved[1] += 1
    return state.held_bytes[block]


def make_z_cache(num_bytes: int, num_ways: int, side: int = TILE) -> ZCacheSpec:
    """A cache of so many bytes of plain blocks, 3 bytes a sample."""
    return ZCacheSpec(num_bytes // (3 * side * side * num_ways), num_ways)


def cache_and_codec(config: TileCacheConfig) -> tuple[ZCacheSpec, CodecSpec]:
    """What a checked section describes."""
    codec = make_codec(
        _CODECS[config.codec],
        config.tile,
        8 * config.granularity,
        FirstRow[config.first_row.upper()],
        LastDelta[config.last_delta.upper()],
    )
    return make_z_cache(config.size, config.ways, config.tile), codec


_CODECS = {
    **{codec.name.lower(): codec for codec in Codec},
    "ddpcm_2": Codec.DDPCM_TWO_PLANES,
    "hasselgren_2": Codec.HASSELGREN_TWO_PLANES,
}


def plain_bytes(codec: CodecSpec) -> int:
    """Bytes of a block that is not compressed."""
    return int(stored_bits(codec, 0)) // 8
