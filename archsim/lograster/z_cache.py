"""The on-chip side of the depth buffer: a cache of whole tiles, and the table of what memory holds for every
tile.

The pipeline tests tiles in order, so which of them are in the cache, and how well each compresses when it
leaves, does not depend on time. Partly drawn tiles go to memory as they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.codec.codec import NUM_WORDS, CodecSpec, encode, load_tile, stored_bits
from archsim.jit import njit
from archsim.lograster.depth_buffer import FARTHEST
from archsim.lograster.grid import TILE

NOWHERE = -1


class ZCacheSpec(NamedTuple):
    """A set-associative cache of tiles, least recently used first out."""

    num_sets: int
    num_ways: int


class ZState(NamedTuple):
    """The depth buffer, its tile table and its cache."""

    depth: np.ndarray  # int32 [rows, columns]
    farthest: np.ndarray  # int32 [tiles] greatest depth of each tile: what z-cull compares with
    held_bytes: np.ndarray  # int64 [tiles] bytes that memory holds; 0: cleared, nothing to read
    tag: np.ndarray  # int64 [sets, ways] tile, or NOWHERE
    last_use: np.ndarray  # int64 [sets, ways]
    dirty: np.ndarray  # bool [sets, ways]
    clock: np.ndarray  # int64 [1] tiles looked up so far
    tile: np.ndarray  # int64 [16] room for the codec
    words: np.ndarray  # int64 [NUM_WORDS] room for the codec


def cleared(rows: int, columns: int, cache: ZCacheSpec) -> ZState:
    """A cleared buffer of whole tiles, an empty cache."""
    num_tiles = (rows // TILE) * (columns // TILE)
    return ZState(
        depth=np.full((rows, columns), FARTHEST, np.int32),
        farthest=np.full(num_tiles, FARTHEST, np.int32),
        held_bytes=np.zeros(num_tiles, np.int64),
        tag=np.full((cache.num_sets, cache.num_ways), NOWHERE, np.int64),
        last_use=np.zeros((cache.num_sets, cache.num_ways), np.int64),
        dirty=np.zeros((cache.num_sets, cache.num_ways), np.bool_),
        clock=np.zeros(1, np.int64),
        tile=np.empty(TILE * TILE, np.int64),
        words=np.empty(NUM_WORDS, np.int64),
    )


@njit
def look_up(state, tile):
    """Bring a tile in: (its set, its way, was it there, the dirty tile that has to leave or NOWHERE)."""
    here = tile % len(state.tag)
    state.clock[0] += 1
    way = 0
    for each in range(state.tag.shape[1]):
        if state.tag[here, each] == tile:
            state.last_use[here, each] = state.clock[0]
            return here, each, True, NOWHERE
        if state.last_use[here, each] < state.last_use[here, way]:
            way = each
    leaving = state.tag[here, way] if state.dirty[here, way] else NOWHERE
    state.tag[here, way] = tile
    state.last_use[here, way] = state.clock[0]
    state.dirty[here, way] = False
    return here, way, False, leaving


@njit
def write_back(state, codec, tile):
    """Compress a tile as it is now; the bytes that memory then holds for it."""
    tile_columns = state.depth.shape[1] // TILE
    load_tile(state.depth, tile // tile_columns, tile % tile_columns, TILE, state.tile)
    used = encode(codec, state.tile, state.words)
    state.held_bytes[tile] = stored_bits(codec, used) // 8
    return state.held_bytes[tile]


def make_z_cache(num_bytes: int, num_ways: int) -> ZCacheSpec:
    """A cache of so many bytes of plain tiles, 48 bytes each."""
    return ZCacheSpec(num_bytes // (48 * num_ways), num_ways)


def plain_bytes(codec: CodecSpec) -> int:
    """Bytes of a tile that is not compressed."""
    return int(stored_bits(codec, 0)) // 8
