"""What each stage of the tile pipeline does for a mesh in a map: records for the machine of fixed-function
stages.

    setup ──> coarse ──> fine ──> z_cull ──> decompress ──> depth_test ──> compress
    triangle  tiles      coverage  tile       reads a block  16 samples     writes a block
                                   table      that is not                   that leaves
                                              in the z cache                the z cache

An item is a triangle up to `coarse`, then a tile of a triangle, then a block that leaves the cache. At the end
a flush command follows the last triangle through all stages, and what is dirty is written.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from archsim.codec.codec import CodecSpec
from archsim.errors import fail
from archsim.jit import njit
from archsim.lograster.clipping import MOST_CORNERS, clip
from archsim.lograster.depth_buffer import (
    LEAST_W,
    NO_OFFSET,
    fan_triangle,
    offset_plane,
    sample_depth,
    snapped,
    steepness,
)
from archsim.lograster.grid import TILE, Grid
from archsim.lograster.offset import OffsetSpec, Switch
from archsim.lograster.row_table import (
    LINE_BYTES,
    NO_LINE,
    NO_TABLE,
    TableSpec,
    empty_buffer,
    missing_line,
)
from archsim.lograster.setup import edge_functions
from archsim.lograster.traversal import coarse, coverage
from archsim.lograster.z_cache import NOWHERE, ZCacheSpec, ZState, block_of, cleared, look_up, write_back
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import PipelineWork

UNITS = ("setup", "coarse", "fine", "z_cull", "decompress", "depth_test", "compress")
SETUP, COARSE, FINE, Z_CULL, DECOMPRESS, DEPTH_TEST, COMPRESS = range(len(UNITS))
PITCH = 4  # bytes from block to block in memory for each sample; a plain one has 3
CHUNK_TILES = 1 << 16
_MOST_RECORDS = 4  # of one tile in one unit: TAKE, LOAD, EMIT, END


class Target(NamedTuple):
    """A shadow map to draw into."""

    grid: Grid
    codec: CodecSpec
    z_cache: ZCacheSpec
    base: int = 0  # address of its first block
    offset: OffsetSpec = NO_OFFSET
    table: TableSpec = NO_TABLE  # of G, where the evaluators of the machine want one


class Tape(NamedTuple):
    """Records of one unit as they are written."""

    records: np.ndarray  # int64 [n, 4] address, compute, bytes, op
    ends: np.ndarray  # int64 [n] number of records up to each task's END
    used: np.ndarray  # int64 [2] records, tasks


class Making(NamedTuple):
    """Everything that the making of work needs, for compiled code."""

    grid: Grid
    codec: CodecSpec
    base: int
    offset: OffsetSpec
    table: TableSpec
    steep: tuple[float, float]  # of the grid's rows
    least_w: float  # where triangles are cut
    chunk_tiles: int
    kept: np.ndarray  # int64 lines of the table that the fine rasterizer has
    state: ZState
    tapes: tuple[Tape, ...]  # of the units


def map_bytes(target: Target) -> int:
    """Memory from `base` on that the blocks of a map take."""
    side = target.codec.side
    return -(-len(target.grid.y) // side) * -(-len(target.grid.x) // side) * side * side * PITCH


def tile_work(
    vertices: np.ndarray, triangles: np.ndarray, target: Target, chunk_tiles: int = CHUNK_TILES
) -> tuple[PipelineWork, ZState]:
    """Work of all units, and the buffer that is complete once the work has been produced.

    A chunk ends with the triangle that brings it to `chunk_tiles` tiles or triangles.
    """
    grid = target.grid
    if target.offset.switch != Switch.INTERPOLATED:
        raise fail("the tile pipeline has one depth plane a triangle: the switch has to be interpolated")
    state = cleared(len(grid.y), len(grid.x), target.z_cache, target.codec.side)
    chunks = _chunks(np.ascontiguousarray(vertices), triangles, target, chunk_tiles, state)
    return PipelineWork(UNITS, chunks), state


def _chunks(
    vertices: np.ndarray, triangles: np.ndarray, target: Target, chunk_tiles: int, state: ZState
) -> Iterator[tuple[Tasks, ...]]:
    """Chunks of whole triangles; the last one ends with the flush."""
    num_tiles = len(state.farthest)
    one_triangle = MOST_CORNERS * (num_tiles + 1)
    flushed = target.z_cache.num_sets * target.z_cache.num_ways
    room = _MOST_RECORDS * (chunk_tiles + one_triangle + flushed + 1)
    kept = empty_buffer(target.table)
    done, finished = 0, False
    while not finished:
        tapes = tuple(
            Tape(np.empty((room, 4), np.int64), np.empty(room, np.int64), np.zeros(2, np.int64))
            for _ in UNITS
        )
        making = Making(
            grid=target.grid,
            codec=target.codec,
            base=target.base,
            offset=target.offset,
            table=target.table,
            steep=steepness(target.grid),
            least_w=LEAST_W * float(np.abs(vertices[:, 3]).max(initial=1e-300)),
            chunk_tiles=chunk_tiles,
            kept=kept,
            state=state,
            tapes=tapes,
        )
        done = _record(making, vertices, triangles, done)
        finished = done == len(triangles)
        if finished:
            _flush(making)
        yield tuple(_tasks(tape) for tape in tapes)


def _tasks(tape: Tape) -> Tasks:
    """What was written, as tasks."""
    num_records, num_tasks = (int(number) for number in tape.used)
    records = np.empty(num_records, RECORD)
    for index, field in enumerate(("address", "compute", "bytes", "op")):
        records[field] = tape.records[:num_records, index]
    return Tasks(np.concatenate([[0], tape.ends[:num_tasks]]), records)


@njit
def _put(tape, op, address, compute, num_bytes):
    """Write one record; END closes the task."""
    at = tape.used[0]
    tape.records[at, 0] = address
    tape.records[at, 1] = compute
    tape.records[at, 2] = num_bytes
    tape.records[at, 3] = op
    tape.used[0] += 1
    if op == Op.END:
        tape.ends[tape.used[1]] = tape.used[0]
        tape.used[1] += 1


@njit
def _record(making, vertices, triangles, first):
    """Write the tasks of triangles from `first` on; the first one that is left for the next chunk."""
    tapes = making.tapes
    polygon, spare = np.empty((MOST_CORNERS, 4)), np.empty((MOST_CORNERS, 4))
    tiles = np.empty((len(making.state.farthest), 2), np.int32)
    corners = np.empty((3, 4))
    for index in range(first, len(triangles)):
        if max(tapes[FINE].used[1], tapes[SETUP].used[1]) >= making.chunk_tiles:
            return index
        for i in range(3):
            corners[i] = vertices[triangles[index, i]]
        num_corners = clip(corners, making.least_w, polygon, spare)
        if num_corners == 0:
            _put(tapes[SETUP], Op.END, 0, 1, 0)
        for i in range(1, num_corners - 1):
            _draw_triangle(making, fan_triangle(polygon, i), tiles)
    return len(triangles)


@njit
def _draw_triangle(making, positions, tiles):
    """Set up a triangle and send its tiles on their way."""
    x, y, z = positions
    grid, tapes = making.grid, making.tapes
    whole_x, whole_y = snapped(x, grid.bits), snapped(y, grid.bits)
    edges = edge_functions(whole_x, whole_y)
    found, tests = 0, 0
    if edges.area > 0:
        found, tests = coarse(edges, whole_x, whole_y, grid, tiles)
    if tests == 0:
        _put(tapes[SETUP], Op.END, 0, 1, 0)
        return
    _put(tapes[SETUP], Op.EMIT, 0, 1, 0)
    _put(tapes[SETUP], Op.END, 0, 0, 0)
    _put(tapes[COARSE], Op.TAKE, 0, 0, 0)
    plane, _ = offset_plane(x, y, z, grid, making.steep, making.offset)
    for k in range(found):
        _put(tapes[COARSE], Op.EMIT, 0, (tests * (k + 1)) // found - (tests * k) // found, 0)
        _draw_tile(making, edges, plane, tiles[k])
    _put(tapes[COARSE], Op.END, 0, tests if found == 0 else 0, 0)


@njit
def _draw_tile(making, edges, plane, tile):
    """The way of one tile of a triangle, as far as it goes."""
    grid, tapes = making.grid, making.tapes
    _put(tapes[FINE], Op.TAKE, 0, 0, 0)
    line = missing_line(making.table, making.kept, tile[0])
    if line != NO_LINE:
        _put(tapes[FINE], Op.LOAD, making.table.base + line * LINE_BYTES, 0, LINE_BYTES)
    mask = coverage(edges, grid, tile[0], tile[1])
    if mask:
        _put(tapes[FINE], Op.EMIT, 0, 0, 0)
        number = tile[0] * (len(grid.x) // TILE) + tile[1]
        _put(tapes[Z_CULL], Op.TAKE, 0, 0, 0)
        if nearest_depth(plane, grid, tile) < making.state.farthest[number]:
            _put(tapes[Z_CULL], Op.EMIT, 0, 0, 0)
            _test_tile(making, mask, plane, tile, number)
        _put(tapes[Z_CULL], Op.END, 0, 0, 0)
    _put(tapes[FINE], Op.END, 0, 0, 0)


@njit
def nearest_depth(plane, grid, tile):
    """A bound below the stored depths of a triangle in a tile: those of its plane at the tile's corner
    samples.
    """
    nearest = 1 << 30
    for i in (0, TILE - 1):
        for k in (0, TILE - 1):
            row, column = tile[0] * TILE + i, tile[1] * TILE + k
            nearest = min(nearest, sample_depth(plane, grid, row, column))
    return nearest


@njit
def _test_tile(making, mask, plane, tile, number):
    """Cache look-up, reading, depth test, and what leaves."""
    state, tapes = making.state, making.tapes
    block = block_of(state, making.codec.side, tile)
    here, way, was_there, leaving = look_up(state, block)
    _put(tapes[DECOMPRESS], Op.TAKE, 0, 0, 0)
    if not was_there and state.held_bytes[block] > 0:
        state.moved[0] += 1
        _put(tapes[DECOMPRESS], Op.LOAD, _address(making, block), 0, state.held_bytes[block])
    _put(tapes[DECOMPRESS], Op.EMIT, 0, 0, 0)
    _put(tapes[DECOMPRESS], Op.END, 0, 0, 0)

    _put(tapes[DEPTH_TEST], Op.TAKE, 0, 0, 0)
    if leaving != NOWHERE:
        _evict(making, leaving)
    _put(tapes[DEPTH_TEST], Op.END, 0, 0, 0)
    farthest = 0
    for i in range(TILE):
        for k in range(TILE):
            row, column = tile[0] * TILE + i, tile[1] * TILE + k
            if mask >> (TILE * i + k) & 1:
                depth = sample_depth(plane, making.grid, row, column)
                if depth < state.depth[row, column]:
                    state.depth[row, column] = depth
                    state.dirty[here, way] = True
            farthest = max(farthest, state.depth[row, column])
    state.farthest[number] = farthest


@njit
def _address(making, block):
    """Where memory holds a block."""
    return making.base + block * making.codec.side * making.codec.side * PITCH


@njit
def _evict(making, block):
    """A dirty block goes from the cache through the compressor to memory."""
    tapes = making.tapes
    _put(tapes[DEPTH_TEST], Op.EMIT, 0, 0, 0)
    _put(tapes[COMPRESS], Op.TAKE, 0, 0, 0)
    num_bytes = write_back(making.state, making.codec, block)
    _put(tapes[COMPRESS], Op.STORE, _address(making, block), 0, num_bytes)
    _put(tapes[COMPRESS], Op.END, 0, 0, 0)


@njit
def _flush(making):
    """The command that follows the last triangle: every stage hands it on, then the cache is emptied."""
    state, tapes = making.state, making.tapes
    for unit in range(DEPTH_TEST):
        if unit > 0:
            _put(tapes[unit], Op.TAKE, 0, 0, 0)
        _put(tapes[unit], Op.EMIT, 0, 0, 0)
        _put(tapes[unit], Op.END, 0, 0, 0)
    _put(tapes[DEPTH_TEST], Op.TAKE, 0, 0, 0)
    for here in range(state.tag.shape[0]):
        for way in range(state.tag.shape[1]):
            if state.dirty[here, way]:
                _evict(making, state.tag[here, way])
                state.dirty[here, way] = False
    _put(tapes[DEPTH_TEST], Op.END, 0, 0, 0)
