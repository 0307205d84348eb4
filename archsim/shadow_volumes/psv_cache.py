"""The on-chip cache in front of the PSV buffers, as far as bytes go: set-associative, LRU, write-back, no time.

An entry is what a 2 x 2 block of tiles keeps, 2 bytes; four entries are 32 x 32 pixels of 8 x 8 tiles, which share a
clear bit. A line that no stage has written back in this volume is all clear, so it is not fetched.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled
from archsim.shadow_volumes.tiles import Screen

ENTRY_BYTES = 2  # 2 x 2 tiles: a boundary bit and a first bit each, and 8 bits of shared stencil
CLEAR_SIDE = 2  # entries along a side of what shares a clear bit


class CacheShape(NamedTuple):
    """Sizes of the cache."""

    size_bytes: int
    line_bytes: int
    ways: int


class PsvCache(NamedTuple):
    """Its state. A line's name is its place in the PSV buffers, all buffers one after the other."""

    line: np.ndarray  # int64 [sets, ways] name, -1 if invalid; the most recently used first
    dirty: np.ndarray  # bool [sets, ways]
    in_memory: np.ndarray  # bool [num_buffers * lines of a buffer] written back since its volume began
    lines_per_buffer: int
    entries_per_line: int
    entry_columns: int  # of a buffer, a multiple of CLEAR_SIDE
    moved: np.ndarray  # int64 [2] lines fetched, lines written back


def new_psv_cache(shape: CacheShape, screen: Screen, num_buffers: int) -> PsvCache:
    """An empty cache."""
    sets = max(1, shape.size_bytes // (shape.line_bytes * shape.ways))
    entries_per_line = shape.line_bytes // ENTRY_BYTES
    rows, columns = (-(-blocks // CLEAR_SIDE) * CLEAR_SIDE for blocks in block_grid(screen))
    lines = -(-rows * columns // entries_per_line)
    return PsvCache(
        np.full((sets, shape.ways), -1, np.int64),
        np.zeros((sets, shape.ways), bool),
        np.zeros(num_buffers * lines, bool),
        lines,
        entries_per_line,
        columns,
        np.zeros(2, np.int64),
    )


def block_grid(screen: Screen) -> tuple[int, int]:
    """Rows and columns of 2 x 2 blocks of tiles."""
    return (screen.rows + 1) // 2, (screen.columns + 1) // 2


@compiled
def entry_of(cache, buffer, block_row, block_column):
    """Place of a block's entry in the PSV buffers, in entries: clear areas one after the other, row by row."""
    area = (block_row // CLEAR_SIDE) * (cache.entry_columns // CLEAR_SIDE) + block_column // CLEAR_SIDE
    entry = area * CLEAR_SIDE * CLEAR_SIDE + (block_row % CLEAR_SIDE) * CLEAR_SIDE + block_column % CLEAR_SIDE
    return buffer * cache.lines_per_buffer * cache.entries_per_line + entry


@compiled
def access(cache, buffer, block_row, block_column, write):
    """Look up a block's entry in a PSV buffer, and make it dirty if it is written."""
    name = entry_of(cache, buffer, block_row, block_column) // cache.entries_per_line
    row = name % cache.line.shape[0]
    ways = cache.line.shape[1]
    place = 0
    while place < ways - 1 and cache.line[row, place] != name:
        place += 1

    dirty = write
    if cache.line[row, place] == name:
        dirty = dirty or cache.dirty[row, place]
    else:
        _evict(cache, row, place)
        if cache.in_memory[name]:
            cache.moved[0] += 1
    while place > 0:
        cache.line[row, place] = cache.line[row, place - 1]
        cache.dirty[row, place] = cache.dirty[row, place - 1]
        place -= 1
    cache.line[row, 0], cache.dirty[row, 0] = name, dirty


@compiled
def _evict(cache, row, place):
    """Write the line back if it is dirty."""
    if cache.line[row, place] >= 0 and cache.dirty[row, place]:
        cache.moved[1] += 1
        cache.in_memory[cache.line[row, place]] = True


@compiled
def release(cache, buffer):
    """Forget a buffer whose volume is done: nothing of it needs to be written back."""
    first = buffer * cache.lines_per_buffer
    end = first + cache.lines_per_buffer
    for row in range(cache.line.shape[0]):
        for place in range(cache.line.shape[1]):
            if first <= cache.line[row, place] < end:
                cache.line[row, place], cache.dirty[row, place] = -1, False
    for line in range(first, end):
        cache.in_memory[line] = False
