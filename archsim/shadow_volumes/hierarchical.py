"""Hierarchical shadow volumes: Stage 1 classifies, Stage 2 draws boundary tiles only. [Aila04] appendix A"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, njit
from archsim.shadow_volumes.delay_stream import popped_early, stream_bytes
from archsim.shadow_volumes.footprint import DepthTest, meet_tiles, trace
from archsim.shadow_volumes.polygon import plane_of, project
from archsim.shadow_volumes.psv_cache import CacheShape, access, new_psv_cache, release
from archsim.shadow_volumes.seen import SeenVolumes, Steps, at_once, new_space
from archsim.shadow_volumes.stage1 import classify, new_psv_buffers
from archsim.shadow_volumes.stencil import Stencil, draw_tile, new_stencil, tile_extremes, values
from archsim.shadow_volumes.tiles import Screen

LIT, SHADOWED, MIXED = 0, 1, 2  # Smin = Smax = 0, Smin = Smax = 1, Smin = 0 and Smax = 1


class Coarse(NamedTuple):
    """The stencil buffer's low resolution."""

    state: np.ndarray  # uint8 [num_tiles] LIT, SHADOWED or MIXED
    drawn: np.ndarray  # bool [num_tiles] pixels were drawn since `state` was found
    full_shadow: np.ndarray  # bool [num_tiles] the FS buffer


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
    counts: HierarchicalCounts


def draw_hierarchically(seen: SeenVolumes, resources: Resources, steps: Steps = at_once) -> Outcome:
    """Draw all volumes; Stage 1 works num_psv_buffers - 1 volumes ahead of Stage 2."""
    volumes, screen = seen.volumes, seen.screen
    num_tiles, ahead = screen.rows * screen.columns, resources.num_psv_buffers - 1
    coarse = Coarse(np.zeros(num_tiles, np.uint8), np.zeros(num_tiles, bool), np.zeros(num_tiles, bool))
    stencil, space = new_stencil(screen), new_space(screen)
    cache = new_psv_cache(resources.psv_cache, screen, resources.num_psv_buffers)
    buffers = (new_psv_buffers(screen, resources.num_psv_buffers), cache)
    sizes = stream_bytes(volumes.triangles, volumes.starts)
    early = popped_early(sizes, volumes.starts, resources.delay_stream_bytes)

    counts = np.zeros(3, np.int64)
    for first, end in steps(len(early) + ahead):
        counts += _run(seen, (first, end), early, space, buffers, (stencil, coarse))
    _settle_all(screen, stencil, coarse)
    counted = HierarchicalCounts(*map(int, (*counts, *cache.moved, 2 * sizes.sum())))
    return Outcome(_mask(screen, stencil, coarse), coarse.state, counted)


def _mask(screen: Screen, stencil: Stencil, coarse: Coarse) -> np.ndarray:
    """bool [height, width]: the tile's state, or the pixel's own stencil value where that is MIXED."""
    state = coarse.state.reshape(screen.rows, screen.columns)
    spread = state.repeat(screen.tile, axis=0).repeat(screen.tile, axis=1)[: screen.height, : screen.width]
    return np.asarray((spread == SHADOWED) | ((spread == MIXED) & (values(screen, stencil) > 0)))


@njit
def _run(seen, steps, early, space, buffers, target):
    """(sample operations, stencil pixels, depth tiles) of some steps: in step n Stage 1 takes volume n."""
    psv, cache = buffers
    num_buffers = len(psv.boundary)
    operations, stencil_pixels, depth_tiles = 0, 0, 0
    for step in range(steps[0], steps[1]):
        if step < len(early):
            operations += classify(step, step % num_buffers, seen, space, psv, cache)
        volume = step - (num_buffers - 1)
        if volume >= 0:
            pixels, tiles = _update(volume, early[volume], seen, space, buffers, target)
            stencil_pixels += pixels
            depth_tiles += tiles
            release(cache, volume % num_buffers)
    return np.array([operations, stencil_pixels, depth_tiles])


@njit
def _update(volume, early, seen, space, buffers, target):
    """Stage 2 of one volume: (stencil pixels, depth tiles)."""
    volumes, points, bounds, screen = seen
    polygon, footprint = space
    buffer = volume % len(buffers[0].boundary)
    test = DepthTest(volumes.z_pass[volume], bounds[volume, 0], bounds[volume, 1])
    stencil_pixels, depth_tiles = 0, 0
    for index in range(volumes.starts[volume], volumes.starts[volume + 1]):
        number = project(points, volumes.triangles[index], screen.frustum, polygon)
        if number == 0:
            continue
        extent = trace(polygon.corners, number, screen, footprint)
        plane = plane_of(polygon.corners, number)
        unclassified = index - volumes.starts[volume] < early
        shape = (footprint, extent, plane, test.z_pass)
        for place in range(meet_tiles(extent, plane, test, screen, footprint)):
            tile, relation = footprint.tile[place], footprint.relation[place]
            if not _needs_pixels(tile, (buffer, unclassified, early > 0), screen, buffers, target):
                continue
            updated, fetched = draw_tile(tile, relation, shape, screen, target[0])
            stencil_pixels += updated
            depth_tiles += fetched
    return stencil_pixels, depth_tiles


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
def _settle_all(screen, stencil, coarse):
    for tile in range(len(coarse.state)):
        settle(tile, screen, stencil, coarse)
