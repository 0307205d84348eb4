"""Shadow volumes drawn pixel by pixel: by brute force, or within depth bounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, njit
from archsim.shadow_volumes.footprint import DepthTest, meet_tiles, reached_tiles, trace
from archsim.shadow_volumes.log import EMIT, TAKE, compute, end_task, put
from archsim.shadow_volumes.polygon import plane_of, project
from archsim.shadow_volumes.seen import SeenVolumes, Steps, at_once, new_space
from archsim.shadow_volumes.stage_logs import drawn
from archsim.shadow_volumes.stencil import Stencil, draw_tile, new_stencil


class DirectCounts(NamedTuple):
    """What drawing took."""

    stencil_pixels: int  # read, changed and written
    depth_tiles: int  # tiles of the z-buffer fetched


def draw_directly(seen: SeenVolumes, steps: Steps = at_once) -> tuple[Stencil, DirectCounts]:
    """Draw all volumes where a tile's depths meet the volume's bounds."""
    stencil, space = new_stencil(seen.screen), new_space(seen.screen)
    counts = np.zeros(2, np.int64)
    for first, end in steps(len(seen.bounds)):
        counts += _draw(seen, first, end, space, stencil)
    return stencil, DirectCounts(*counts.tolist())


@njit
def _draw(seen, first, end, space, stencil):
    """Draw volumes first ... end - 1: (stencil pixels, depth tiles)."""
    starts = seen.volumes.starts
    counts = np.zeros(2, np.int64)
    for volume in range(first, end):
        counts += draw_triangles(volume, (starts[volume], starts[volume + 1]), seen, space, stencil)
    return counts


@njit
def draw_triangles(volume, triangles, seen, space, stencil, logs=None):
    """Draw triangles (first, end) of a volume: int64 [2] stencil pixels, depth tiles.

    logs: where to write down the units' work, DirectLogs, or None; then all triangles are drawn ones.
    """
    volumes, points, bounds, screen = seen
    polygon, footprint = space
    counts = np.zeros(2, np.int64)
    test = DepthTest(volumes.z_pass[volume], bounds[volume, 0], bounds[volume, 1])
    for index in range(triangles[0], triangles[1]):
        if logs is not None:
            put(logs.records, TAKE, 0, 0)
        number = project(points, volumes.triangles[index], screen.frustum, polygon)
        if number > 0 and index >= volumes.drawn[volume]:
            extent = trace(polygon.corners, number, screen, footprint)
            shape = (footprint, extent, plane_of(polygon.corners, number), test.z_pass)
            met = meet_tiles(extent, shape[2], test, screen, footprint)
            _draw_tiles(met, shape, screen, stencil, counts, logs)
        if logs is not None:
            end_task(logs.records)
    return counts


@compiled
def _draw_tiles(met, shape, screen, stencil, counts, logs):
    """One polygon in all tiles that it meets."""
    footprint, extent = shape[0], shape[1]
    for place in range(met):
        tile, relation = footprint.tile[place], footprint.relation[place]
        updated, fetched = draw_tile(tile, relation, shape, screen, stencil)
        counts[0] += updated
        counts[1] += fetched
        if logs is not None:
            compute(logs.records, 1)
            put(logs.records, EMIT, 0, 0)
            drawn(logs.drawing, 1, tile, updated, fetched)
    if logs is not None:
        compute(logs.records, max(0, reached_tiles(extent, screen, footprint) - met))
