"""Hierarchical shadow volumes: Stage 1 classifies, Stage 2 draws boundary tiles only. [Aila04] appendix A"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, njit
from archsim.shadow_volumes.delay_stream import popped_early, stream_bytes
from archsim.shadow_volumes.footprint import DepthTest, meet_tiles, reached_tiles, trace
from archsim.shadow_volumes.log import EMIT, compute, put
from archsim.shadow_volumes.polygon import plane_of, project
from archsim.shadow_volumes.psv_cache import CacheShape, PsvCache, access, new_psv_cache, release
from archsim.shadow_volumes.seen import SeenVolumes, Steps, at_once, new_space
from archsim.shadow_volumes.stage1 import PsvBuffers, classify, new_psv_buffers
from archsim.shadow_volumes.stage_logs import begin_update, drawn, end_update, look_up
from archsim.shadow_volumes.stencil import Stencil, draw_tile, layers, new_stencil, tile_extremes, values
from archsim.shadow_volumes.tiles import Screen, spread

LIT, SHADOWED, MIXED = 0, 1, 2  # Smin = Smax = 0, Smin = Smax = 1, Smin = 0 and Smax = 1


class Coarse(NamedTuple):
    """The stencil buffer's low resolution."""

    state: np.ndarray  # uint8 [num_tiles] LIT, SHADOWED or MIXED
    drawn: np.ndarray  # bool [num_tiles] pixels were drawn since `state` was found
    full_shadow: np.ndarray  # bool [num_tiles] the FS buffer


Memory = tuple[tuple[PsvBuffers, PsvCache], tuple[Stencil, Coarse]]  # what the two stages change


class HierarchicalCounts(NamedTuple):
    """What both stages took."""

    sample_operations: int  # Stage 1: stencil operations on the samples of tiles
    stencil_pixels: int  # Stage 2: read, changed and written
    depth_tiles: int
    psv_lines_read: int
    psv_lines_written: int
    delay_stream_bytes: int  # written and read


class Resources(NamedTuple):
    """What the machine has for the two stages."""

    num_psv_buffers: int
    psv_cache: CacheShape
    delay_stream_bytes: int


class Outcome(NamedTuple):
    """A finished shadow mask."""

    shadow: np.ndarray  # bool [height, width]
    state: np.ndarray  # uint8 [num_tiles] LIT, SHADOWED or MIXED
    layers: np.ndarray  # int32 [height, width] stencil updates of each pixel
    counts: HierarchicalCounts


def draw_hierarchically(seen: SeenVolumes, resources: Resources, steps: Steps = at_once) -> Outcome:
    """Draw all volumes; Stage 1 works num_psv_buffers - 1 volumes ahead of Stage 2."""
    volumes, screen = seen.volumes, seen.screen
    space, ahead = new_space(screen), resources.num_psv_buffers - 1
    buffers, target = new_memory(screen, resources)
    sizes = stream_bytes(volumes.triangles, volumes.starts, volumes.drawn)
    early = popped_early(sizes, volumes.starts, resources.delay_stream_bytes)

    counts = np.zeros(3, np.int64)
    for first, end in steps(len(early) + ahead):
        counts += _run(seen, (first, end), early, space, buffers, target)
    finish(screen, (buffers, target))
    counted = HierarchicalCounts(*map(int, (*counts, *buffers[1].moved, 2 * sizes.sum())))
    stencil, coarse = target
    return Outcome(mask(screen, stencil, coarse.state), coarse.state, layers(screen, stencil), counted)


def new_memory(screen: Screen, resources: Resources) -> Memory:
    """Cleared."""
    num_tiles = screen.rows * screen.columns
    coarse = Coarse(np.zeros(num_tiles, np.uint8), np.zeros(num_tiles, bool), np.zeros(num_tiles, bool))
    cache = new_psv_cache(resources.psv_cache, screen, resources.num_psv_buffers)
    return (new_psv_buffers(screen, resources.num_psv_buffers), cache), (new_stencil(screen), coarse)


def finish(screen: Screen, memory: Memory) -> None:
    """Bring the low-resolution stencil buffer up to date when all volumes are drawn."""
    settle_all(screen, *memory[1])


def mask(screen: Screen, stencil: Stencil, states: np.ndarray) -> np.ndarray:
    """bool [height, width]: the tile's state, or the pixel's own stencil value where that is MIXED."""
    state = spread(screen, states)
    return np.asarray((state == SHADOWED) | ((state == MIXED) & (values(screen, stencil) > 0)))


@njit
def _run(seen, steps, early, space, buffers, target):
    """(sample operations, stencil pixels, depth tiles) of some steps: in step n Stage 1 takes volume n."""
    psv, cache = buffers
    num_buffers = len(psv.boundary)
    operations, stencil_pixels, depth_tiles = 0, 0, 0
    for step in range(steps[0], steps[1]):
        if step < len(early):
            operations += classify(step, _all_of(seen, step), seen, space, buffers)
        volume = step - (num_buffers - 1)
        if volume >= 0:
            pixels, tiles = update(volume, _all_of(seen, volume), early, seen, space, (buffers, target))
            stencil_pixels += pixels
            depth_tiles += tiles
            release(cache, volume % num_buffers)
    return np.array([operations, stencil_pixels, depth_tiles])


@njit
def update(volume, triangles, early, seen, space, memory, logs=None):
    """Stage 2 of triangles (first, end) of a volume: (stencil pixels, depth tiles).

    memory: Memory. logs: where to write down the units' work, Stage2Logs, or None; then all triangles are drawn ones.
    """
    volumes, points, bounds, screen = seen
    polygon, footprint = space
    buffer = volume % len(memory[0][0].boundary)
    test = DepthTest(volumes.z_pass[volume], bounds[volume, 0], bounds[volume, 1])
    stencil_pixels, depth_tiles = 0, 0
    for index in range(triangles[0], triangles[1]):
        if logs is not None:
            begin_update(logs, index == volumes.drawn[volume])
        number = project(points, volumes.triangles[index], screen.frustum, polygon)
        if number > 0 and index >= volumes.drawn[volume]:
            extent = trace(polygon.corners, number, screen, footprint)
            shape = (footprint, extent, plane_of(polygon.corners, number), test.z_pass)
            state = (buffer, index - volumes.starts[volume] < early[volume], early[volume] > 0)
            met = meet_tiles(extent, shape[2], test, screen, footprint)
            pixels, tiles = _update_tiles(met, state, shape, screen, memory, logs)
            stencil_pixels += pixels
            depth_tiles += tiles
        if logs is not None:
            end_update(logs, memory[0][1], buffer, index + 1 == volumes.starts[volume + 1])
    return stencil_pixels, depth_tiles


@compiled
def _update_tiles(met, state, shape, screen, memory, logs):
    """One triangle in all tiles that it meets: (stencil pixels, depth tiles). state: see `_needs_pixels`."""
    footprint, extent = shape[0], shape[1]
    buffers, target = memory
    stencil_pixels, depth_tiles = 0, 0
    for place in range(met):
        tile, relation = footprint.tile[place], footprint.relation[place]
        if logs is not None:
            compute(logs.records, 1)
            look_up(logs, buffers, state[0], footprint.tile, place, screen)
        if not _needs_pixels(tile, state, screen, buffers, target):
            continue
        updated, fetched = draw_tile(tile, relation, shape, screen, target[0])
        stencil_pixels += updated
        depth_tiles += fetched
        if logs is not None:
            put(logs.records, EMIT, 0, 0)
            drawn(logs.drawing, 0, tile, updated, fetched)
    if logs is not None:
        compute(logs.records, max(0, reached_tiles(extent, screen, footprint) - met))
    return stencil_pixels, depth_tiles


@njit
def _all_of(seen, volume):
    """Half-open range of a volume's triangles."""
    return seen.volumes.starts[volume], seen.volumes.starts[volume + 1]


@compiled
def _needs_pixels(tile, volume, screen, buffers, target):
    """Whether a triangle has to be drawn pixel by pixel in a tile; the low-resolution stencil is updated if not.

    volume: (PSV buffer, whether it is not classified yet, whether it was not when its first triangles came).
    """
    buffer, unclassified, overflowed = volume
    psv, cache = buffers
    stencil, coarse = target
    block_row, block_column = tile // screen.columns // 2, tile % screen.columns // 2
    access(cache, buffer, block_row, block_column, psv.first[buffer, tile])
    if psv.first[buffer, tile]:
        psv.first[buffer, tile] = False
        settle(tile, screen, stencil, coarse)
        coarse.full_shadow[tile] = coarse.state[tile] == SHADOWED
    if coarse.full_shadow[tile]:
        return False

    is_boundary = unclassified or psv.boundary[buffer, tile]
    if not is_boundary and psv.stencil[buffer, block_row, block_column] > 0:
        coarse.state[tile], coarse.drawn[tile], coarse.full_shadow[tile] = SHADOWED, False, True
        return False
    if not is_boundary and not overflowed:
        return False
    coarse.drawn[tile] = True  # a lit tile of a volume that was drawn in part has to be drawn to its end
    return True


@compiled
def settle(tile, screen, stencil, coarse):
    """Bring a tile's state up to date with its pixels."""
    if coarse.drawn[tile]:
        low, high = tile_extremes(tile, screen, stencil)
        coarse.state[tile] = SHADOWED if low > 0 else LIT if high <= 0 else MIXED
        coarse.drawn[tile] = False


@njit
def settle_all(screen, stencil, coarse):
    """Bring every tile's state up to date."""
    for tile in range(len(coarse.state)):
        settle(tile, screen, stencil, coarse)
