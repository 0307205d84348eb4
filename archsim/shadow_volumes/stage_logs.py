"""What each stage of the pipeline of configs/machines/aila2004.yaml does for a triangle or a tile, as records."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled
from archsim.shadow_volumes.log import (
    ACQUIRE,
    CLEAR,
    EMIT,
    LOAD,
    MARK,
    RELEASE,
    STORE,
    TAKE,
    Log,
    compute,
    end_task,
    put,
)
from archsim.shadow_volumes.psv_cache import ENTRY_BYTES, entry_of

MOST_BYTES = 1 << 14  # of a CLEAR


class Layout(NamedTuple):
    """Where the buffers lie in memory: byte addresses."""

    depth: int  # compressed tiles of the z-buffer, one after the other
    depth_tile_bytes: int
    stencil: int  # tiles of the stencil buffer, a byte a pixel
    stencil_tile_bytes: int
    psv: int  # the PSV buffers


class Drawing(NamedTuple):
    """Logs of the units behind the tiles."""

    depth: Log
    stencil: Log
    layout: Layout


class DirectLogs(NamedTuple):
    """Logs of a rasterizer without stages and of what follows it."""

    records: Log
    drawing: Drawing


class Stage1Log(NamedTuple):
    """Log of Stage 1."""

    records: Log
    sizes: np.ndarray  # int64 [num_triangles] bytes of each triangle in the delay stream
    layout: Layout
    two_passes: bool


class Stage2Logs(NamedTuple):
    """Logs of Stage 2 and of what follows it."""

    records: Log
    drawing: Drawing
    two_passes: bool


@compiled
def begin_triangle(log, cache, buffer, is_first):
    """Stage 1 gets a triangle; with the first of a volume it waits for a PSV buffer and sets its clear bits."""
    put(log.records, TAKE, 0, 0)
    if not is_first:
        return
    put(log.records, ACQUIRE, 0, 0)
    _clear(log.records, log.layout, cache, buffer)


@compiled
def change_entry(log, cache, buffer, tile, screen):
    """Stage 1 reads and writes the PSV entry of a tile's block."""
    address = _entry_address(log.layout, cache, buffer, tile, screen)
    put(log.records, LOAD, address, ENTRY_BYTES)
    put(log.records, STORE, address, ENTRY_BYTES)


@compiled
def end_triangle(log, index, is_last):
    """Stage 1 passes a drawn triangle on; ESV goes past the delay stream, or alone where there are two passes."""
    if not log.two_passes:
        if log.sizes[index] > 0:
            put(log.records, EMIT, 0, log.sizes[index])
        if is_last:
            put(log.records, MARK, 0, 0)
    elif is_last:
        put(log.records, EMIT, 1, 0)
    end_task(log.records)


@compiled
def begin_update(logs, is_first):
    """Stage 2 gets a triangle: out of the delay stream, or once more, when the volume is classified."""
    if not logs.two_passes:
        put(logs.records, TAKE, 0, 0)
        return
    if is_first:
        put(logs.records, TAKE, 1, 0)
    put(logs.records, TAKE, 2, 0)


@compiled
def look_up(logs, buffers, buffer, tiles, place, screen):
    """Stage 2 reads the PSV entry of a tile's block, once a block, and writes it when it meets the tile first."""
    psv, cache = buffers
    tile = tiles[place]
    is_first = psv.first[buffer, tile]
    if place > 0 and _block(tiles[place - 1], screen) == _block(tile, screen) and not is_first:
        return
    address = _entry_address(logs.drawing.layout, cache, buffer, tile, screen)
    put(logs.records, LOAD, address, ENTRY_BYTES)
    if is_first:
        put(logs.records, STORE, address, ENTRY_BYTES)


@compiled
def end_update(logs, cache, buffer, is_last):
    """Stage 2 is done with a triangle; with the last of a volume the PSV buffer is free, and none of it is kept."""
    if is_last:
        _clear(logs.records, logs.drawing.layout, cache, buffer)
        put(logs.records, RELEASE, 0, 0)
    end_task(logs.records)


@compiled
def drawn(drawing, channel, tile, updated, fetched):
    """A tile goes through depth and stencil unit; `channel`: which of its inputs the depth unit takes it from."""
    put(drawing.depth, TAKE, channel, 0)
    if fetched:
        address = drawing.layout.depth + tile * drawing.layout.depth_tile_bytes
        put(drawing.depth, LOAD, address, drawing.layout.depth_tile_bytes)
    if updated > 0:
        put(drawing.depth, EMIT, 0, 0)
        address = drawing.layout.stencil + tile * drawing.layout.stencil_tile_bytes
        put(drawing.stencil, TAKE, 0, 0)
        put(drawing.stencil, LOAD, address, updated)
        compute(drawing.stencil, updated)
        put(drawing.stencil, STORE, address, updated)
        end_task(drawing.stencil)
    end_task(drawing.depth)


@compiled
def _clear(records, layout, cache, buffer):
    """The cache forgets what it holds of a PSV buffer and sets its clear bits."""
    size = cache.lines_per_buffer * cache.entries_per_line * ENTRY_BYTES
    address, end = layout.psv + buffer * size, layout.psv + (buffer + 1) * size
    while address < end:
        put(records, CLEAR, address, min(MOST_BYTES, end - address))
        address += MOST_BYTES


@compiled
def _entry_address(layout, cache, buffer, tile, screen):
    block_row, block_column = tile // screen.columns // 2, tile % screen.columns // 2
    return layout.psv + ENTRY_BYTES * entry_of(cache, buffer, block_row, block_column)


@compiled
def _block(tile, screen):
    """Names the block of 2 x 2 tiles."""
    return (tile // screen.columns // 2) * screen.columns + tile % screen.columns // 2
