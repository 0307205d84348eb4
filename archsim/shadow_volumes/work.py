"""The work of the pipeline of configs/machines/aila2004.yaml for one light's shadow volumes, chunk by chunk.

A triangle is an item from the geometry unit on; a tile that has to be drawn is an item behind Stage 2 or the plain
rasterizer. A last item through the plain rasterizer tells the stencil unit that the mask is complete; then the lighting
unit reads it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.shadow_volumes.comparison import (
    DEPTH_BYTES,
    DEPTH_COMPRESSION,
    STENCIL_BYTES,
    View,
    is_bounded,
    is_hierarchical,
)
from archsim.shadow_volumes.delay_stream import popped_early, stream_bytes
from archsim.shadow_volumes.direct import draw_triangles
from archsim.shadow_volumes.footprint import DepthTest, meet_tiles, trace
from archsim.shadow_volumes.hierarchical import MIXED, Memory, Resources, finish, new_memory, update
from archsim.shadow_volumes.log import EMIT, END, LOAD, TAKE, logged, new_log
from archsim.shadow_volumes.polygon import plane_of, project
from archsim.shadow_volumes.psv_cache import ENTRY_BYTES, release
from archsim.shadow_volumes.seen import SeenVolumes, new_space
from archsim.shadow_volumes.stage1 import classify
from archsim.shadow_volumes.stage_logs import (
    MOST_BYTES,
    DirectLogs,
    Drawing,
    Layout,
    Stage1Log,
    Stage2Logs,
)
from archsim.shadow_volumes.stencil import new_stencil
from archsim.shadow_volumes.tiles import Screen, tiled
from archsim.trace.records import RECORD, Tasks
from archsim.trace.stream import PipelineWork

UNITS = ("geometry", "stage_1", "stage_2", "rasterizer", "depth", "stencil", "lighting")
SINGLE_PASS, TWO_PASSES, PLAIN = range(3)  # outputs of the geometry unit: triangles, again, plain
_CHUNK_TILES = 1 << 16  # tiles met in a chunk, about; a task of each unit at most for each
_MEGABYTE = 1 << 20
_PLAIN_TILE = 1  # input of the depth unit


class Step(NamedTuple):
    """Some triangles of one volume in one of the passes over it."""

    unit: int  # 1 or 2: the stage, 3: the plain rasterizer
    volume: int
    first: int  # triangles
    end: int


def needed_bytes(screen: Screen, num_buffers: int) -> int:
    """Memory that the work's buffers take, from address 0; the delay stream is the machine's."""
    layout = layout_of(screen, num_buffers)
    return layout.stencil + screen.rows * screen.columns * layout.stencil_tile_bytes


def layout_of(screen: Screen, num_buffers: int) -> Layout:
    """PSV buffers, z-buffer and stencil buffer one after the other, each on a whole megabyte."""
    num_tiles, pixels = screen.rows * screen.columns, screen.tile**2
    depth_bytes, stencil_bytes = int(pixels * DEPTH_BYTES * DEPTH_COMPRESSION), pixels * STENCIL_BYTES
    depth = _rounded(num_buffers * (screen.rows + 4) * (screen.columns + 4) + _MEGABYTE // 2)
    return Layout(depth, depth_bytes, depth + _rounded(num_tiles * depth_bytes), stencil_bytes, 0)


def _rounded(num_bytes: int) -> int:
    """Up to a whole megabyte."""
    return -(-num_bytes // _MEGABYTE) * _MEGABYTE


def pipeline_work(view: View, variant: str, resources: Resources, two_passes: bool = False) -> PipelineWork:
    """The work of one variant of `comparison.py`; `two_passes`: volumes are submitted twice ([Aila04] sec. 4.2)."""
    seen = view.seen._replace(bounds=view.bounds) if is_bounded(variant) else view.seen
    if is_hierarchical(variant):
        return PipelineWork(UNITS, _hierarchical(view, seen, resources, two_passes))
    return PipelineWork(UNITS, _direct(view, seen))


def _hierarchical(
    view: View, seen: SeenVolumes, resources: Resources, two_passes: bool
) -> Iterator[tuple[Tasks, ...]]:
    screen, layout = seen.screen, layout_of(seen.screen, resources.num_psv_buffers)
    sizes = stream_bytes(seen.volumes.triangles, seen.volumes.starts, seen.volumes.drawn)
    capacity = np.iinfo(np.int64).max if two_passes else resources.delay_stream_bytes
    early = popped_early(sizes, seen.volumes.starts, capacity)
    space, memory = new_space(screen), new_memory(screen, resources)
    for steps, num_tiles in _chunks(seen, (1, 2)):
        triangles = sum(step.end - step.first for step in steps)
        clears = _clears(steps, memory)
        logs = [
            new_log(5 * triangles + 2 * num_tiles + clears, triangles),
            new_log(4 * triangles + 3 * num_tiles + clears, triangles),
        ]
        drawing = _new_drawing(num_tiles, layout)
        stages = (Stage1Log(logs[0], sizes, layout, two_passes), Stage2Logs(logs[1], drawing, two_passes))
        for step in steps:
            span = (step.first, step.end)
            if step.unit == 1:
                classify(step.volume, span, seen, space, memory[0], stages[0])
            else:
                update(step.volume, span, early, seen, space, memory, stages[1])
                if step.end == seen.volumes.starts[step.volume + 1]:
                    release(memory[0][1], step.volume % resources.num_psv_buffers)
        yield (
            _geometry(steps, two_passes),
            logged(logs[0]),
            logged(logs[1]),
            _nothing(),
            logged(drawing.depth),
            logged(drawing.stencil),
            _nothing(),
        )
    finish(screen, memory)
    yield _closing(_fetches_of_mixed(view, screen, memory[1][1].state, layout))


def _direct(view: View, seen: SeenVolumes) -> Iterator[tuple[Tasks, ...]]:
    screen, layout = seen.screen, layout_of(seen.screen, 1)
    space, stencil = new_space(screen), new_stencil(screen)
    for steps, num_tiles in _chunks(seen, (3,)):
        triangles = sum(step.end - step.first for step in steps)
        log, drawing = new_log(2 * triangles + num_tiles, triangles), _new_drawing(num_tiles, layout)
        for step in steps:
            draw_triangles(
                step.volume, (step.first, step.end), seen, space, stencil, DirectLogs(log, drawing)
            )
        yield (
            _geometry(steps, False),
            _nothing(),
            _nothing(),
            logged(log),
            logged(drawing.depth),
            logged(drawing.stencil),
            _nothing(),
        )
    yield _closing(_fetches_of_all(view, screen, layout))


def _clears(steps: list[Step], memory: Memory) -> int:
    """Records that clear PSV buffers, at most."""
    cache = memory[0][1]
    size = cache.lines_per_buffer * cache.entries_per_line * ENTRY_BYTES
    return len(steps) * -(-size // MOST_BYTES)


def _new_drawing(num_tiles: int, layout: Layout) -> Drawing:
    return Drawing(new_log(4 * num_tiles, num_tiles), new_log(4 * num_tiles, num_tiles), layout)


def _chunks(seen: SeenVolumes, units: tuple[int, ...]) -> Iterator[tuple[list[Step], int]]:
    """(steps, tiles that they meet at most) of each chunk: every volume in all passes, one after the other."""
    met = _tiles_met(seen, new_space(seen.screen))
    steps: list[Step] = []
    num_tiles = 0
    for step in _steps(seen, units, met):
        steps.append(step)
        num_tiles += int(met[step.first : step.end].sum())
        if num_tiles + step.end - step.first > _CHUNK_TILES:
            yield steps, num_tiles
            steps, num_tiles = [], 0
    if steps:
        yield steps, num_tiles


def _steps(seen: SeenVolumes, units: tuple[int, ...], met: np.ndarray) -> Iterator[Step]:
    """Every volume in all passes, large ones in several steps. What is not drawn goes through Stage 1 only."""
    starts, drawn = seen.volumes.starts, seen.volumes.drawn
    for volume in range(len(starts) - 1):
        for unit in units:
            start, end = starts[volume] if unit == 1 else drawn[volume], starts[volume + 1]
            cuts = _cuts(met[start:end]) + start
            for first, end in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
                yield Step(unit, volume, first, end)


def _cuts(met: np.ndarray) -> np.ndarray:
    """Where to cut a volume's triangles, both ends included: each part meets about _CHUNK_TILES tiles."""
    if not len(met):
        return np.zeros(1, np.int64)
    part = np.cumsum(met + 1) // _CHUNK_TILES
    return np.concatenate([[0], np.flatnonzero(np.diff(part)) + 1, [len(met)]])


@njit
def _tiles_met(seen, space):
    """int64 [num_triangles]: tiles that each triangle meets."""
    volumes, points, bounds, screen = seen
    polygon, footprint = space
    met = np.zeros(len(volumes.triangles), np.int64)
    for volume in range(len(bounds)):
        test = DepthTest(volumes.z_pass[volume], bounds[volume, 0], bounds[volume, 1])
        for index in range(volumes.starts[volume], volumes.starts[volume + 1]):
            number = project(points, volumes.triangles[index], screen.frustum, polygon)
            if number > 0:
                extent = trace(polygon.corners, number, screen, footprint)
                plane = plane_of(polygon.corners, number)
                met[index] = meet_tiles(extent, plane, test, screen, footprint)
    return met


def _geometry(steps: list[Step], two_passes: bool) -> Tasks:
    """A task for each triangle submitted: into which output it goes."""
    outputs = {1: SINGLE_PASS, 2: TWO_PASSES, 3: PLAIN}
    counts = [0 if step.unit == 2 and not two_passes else step.end - step.first for step in steps]
    return _emitting(np.repeat([outputs[step.unit] for step in steps], counts))


def _emitting(outputs: np.ndarray) -> Tasks:
    """One item to each of these outputs."""
    records = np.zeros(2 * len(outputs), RECORD)
    records["op"][::2], records["address"][::2] = EMIT, outputs
    records["op"][1::2] = END
    return Tasks(np.arange(0, 2 * len(outputs) + 1, 2), records)


def _nothing() -> Tasks:
    return Tasks(np.zeros(1, np.int64), np.zeros(0, RECORD))


def _closing(fetches: np.ndarray) -> tuple[Tasks, ...]:
    """The last chunk: an item from the geometry unit to the lighting unit, which then fetches (address, bytes)."""
    passing = [(0, TAKE, 0), (0, EMIT, 0)]
    from_plain = [(_PLAIN_TILE, TAKE, 0), (0, EMIT, 0)]
    reading = [(0, TAKE, 0), *((int(address), LOAD, int(size)) for address, size in fetches)]
    plans = {"rasterizer": passing, "depth": from_plain, "stencil": passing, "lighting": reading}
    return (
        _emitting(np.array([PLAIN])),
        *(_task(plans[unit]) if unit in plans else _nothing() for unit in UNITS[1:]),
    )


def _task(operations: list[tuple[int, int, int]]) -> Tasks:
    """One task of (address, operation, bytes)."""
    records = np.zeros(len(operations) + 1, RECORD)
    for record, (address, op, size) in zip(records, operations, strict=False):
        record["address"], record["op"], record["bytes"] = address, op, size
    records["op"][-1] = END
    return Tasks(np.array([0, len(records)]), records)


def _fetches_of_mixed(view: View, screen: Screen, state: np.ndarray, layout: Layout) -> np.ndarray:
    """int64 [n, 2] (address, bytes) of the tiles that show something and are lit in part."""
    tiles = np.flatnonzero(tiled(view.shown, screen.tile, 0).any(axis=1) & (state == MIXED))
    return _fetches(tiles, np.full(len(tiles), layout.stencil_tile_bytes), layout)


def _fetches_of_all(view: View, screen: Screen, layout: Layout) -> np.ndarray:
    """The same of all tiles that show something: a byte for each pixel that does."""
    shown = tiled(view.shown, screen.tile, 0).sum(axis=1) * STENCIL_BYTES
    tiles = np.flatnonzero(shown)
    return _fetches(tiles, shown[tiles], layout)


def _fetches(tiles: np.ndarray, sizes: np.ndarray, layout: Layout) -> np.ndarray:
    return np.stack([layout.stencil + tiles * layout.stencil_tile_bytes, sizes], axis=1)
