"""Shadow volumes drawn pixel by pixel: by brute force, or within depth bounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.shadow_volumes.footprint import DepthTest, meet_tiles, trace
from archsim.shadow_volumes.polygon import plane_of, project
from archsim.shadow_volumes.seen import SeenVolumes, Steps, at_once, new_space
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
    volumes, points, bounds, screen = seen
    polygon, footprint = space
    stencil_pixels, depth_tiles = 0, 0
    for volume in range(first, end):
        test = DepthTest(volumes.z_pass[volume], bounds[volume, 0], bounds[volume, 1])
        for index in range(volumes.starts[volume], volumes.starts[volume + 1]):
            number = project(points, volumes.triangles[index], screen.frustum, polygon)
            if number == 0:
                continue
            extent = trace(polygon.corners, number, screen, footprint)
            plane = plane_of(polygon.corners, number)
            shape = (footprint, extent, plane, test.z_pass)
            for place in range(meet_tiles(extent, plane, test, screen, footprint)):
                tile, relation = footprint.tile[place], footprint.relation[place]
                updated, fetched = draw_tile(tile, relation, shape, screen, stencil)
                stencil_pixels += updated
                depth_tiles += fetched
    return np.array([stencil_pixels, depth_tiles])
