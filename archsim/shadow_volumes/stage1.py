"""Stage 1: tiles that a volume's boundary may pass through, and whether others are in its shadow. [Aila04] 3.2.1"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, njit
from archsim.shadow_volumes.footprint import (
    CUTS,
    DepthTest,
    covers_sample,
    meet_tiles,
    reached_tiles,
    trace,
)
from archsim.shadow_volumes.log import compute
from archsim.shadow_volumes.polygon import plane_of, project
from archsim.shadow_volumes.psv_cache import access, block_grid
from archsim.shadow_volumes.stage_logs import begin_triangle, change_entry, end_triangle
from archsim.shadow_volumes.tiles import Screen


class PsvBuffers(NamedTuple):
    """Per-shadow-volume (PSV) buffers; B of them, so that several volumes can be between Stage 1 and Stage 2."""

    boundary: np.ndarray  # bool [B, num_tiles] a shadow boundary may be in the tile
    first: np.ndarray  # bool [B, num_tiles] Stage 2 has not met the tile yet in this volume
    stencil: np.ndarray  # int32 [B, block rows, block columns] at the common corner of 2 x 2 tiles


def new_psv_buffers(screen: Screen, num_buffers: int) -> PsvBuffers:
    num_tiles = screen.rows * screen.columns
    return PsvBuffers(
        np.zeros((num_buffers, num_tiles), bool),
        np.ones((num_buffers, num_tiles), bool),
        np.zeros((num_buffers, *block_grid(screen)), np.int32),
    )


@njit
def classify(volume, triangles, seen, space, buffers, log=None):
    """Take triangles (first, end) of a volume into its PSV buffer; the number of stencil operations on samples.

    log: where to write down the unit's work, a Stage1Log, or None.
    """
    volumes, points, bounds, screen = seen
    polygon, footprint = space
    psv = buffers[0]
    buffer = volume % len(psv.boundary)
    if triangles[0] == volumes.starts[volume]:
        psv.boundary[buffer] = False
        psv.first[buffer] = True
        psv.stencil[buffer] = 0
    test = DepthTest(volumes.z_pass[volume], bounds[volume, 0], bounds[volume, 1])
    operations = 0
    for index in range(triangles[0], triangles[1]):
        if log is not None:
            begin_triangle(log, buffers[1], buffer, index == volumes.starts[volume])
        number = project(points, volumes.triangles[index], screen.frustum, polygon)
        if number > 0:
            extent = trace(polygon.corners, number, screen, footprint)
            plane = plane_of(polygon.corners, number)
            met = meet_tiles(extent, plane, test, screen, footprint)
            triangle = (footprint, extent, test.z_pass, index < volumes.drawn[volume])
            operations += _classify_blocks(met, triangle, buffer, screen, buffers, log)
        if log is not None:
            end_triangle(log, index, index + 1 == volumes.starts[volume + 1])
    return operations


@compiled
def _classify_blocks(met, triangle, buffer, screen, buffers, log):
    """One triangle in all blocks that it meets; tiles whose sample it changes."""
    footprint, extent = triangle[0], triangle[1]
    place, operations, visited = 0, 0, 0
    while place < met:
        end = block_end(footprint, place, met, screen)
        changed, accessed = _classify_block((place, end), triangle, buffer, screen, buffers)
        operations += changed
        if log is not None:
            compute(log.records, end - place)
            visited += end - place
            if accessed:
                change_entry(log, buffers[1], buffer, footprint.tile[place], screen)
        place = end
    if log is not None:
        compute(log.records, max(0, reached_tiles(extent, screen, footprint) - visited))
    return operations


@compiled
def block_end(footprint, place, met, screen):
    """Where the tiles of the block that starts at `place` end."""
    block_row = footprint.tile[place] // screen.columns // 2
    block_column = footprint.tile[place] % screen.columns // 2
    end = place + 1
    while (
        end < met
        and footprint.tile[end] // screen.columns // 2 == block_row
        and footprint.tile[end] % screen.columns // 2 == block_column
    ):
        end += 1
    return end


@compiled
def _classify_block(places, triangle, buffer, screen, buffers):
    """One triangle in one block of 2 x 2 tiles: (tiles whose sample it changes, whether the PSV entry was needed).

    The tiles share their stencil value, but a triangle can be behind one and before another. Then the value is that of
    those that it is behind, and the others become boundary tiles, which never does harm. So do those at whose sample
    there is a triangle that is not drawn: a volume without it would be open there.
    """
    place, end = places
    footprint, extent, z_pass, is_undrawn = triangle
    psv, cache = buffers
    block_row = footprint.tile[place] // screen.columns // 2
    block_column = footprint.tile[place] % screen.columns // 2
    sample = covers_sample(extent, footprint, block_row, block_column)
    changed, cut = 0, False
    for k in range(place, end):
        if footprint.relation[k] == CUTS or (is_undrawn and sample != 0):
            psv.boundary[buffer, footprint.tile[k]] = True
            cut = True
        elif sample != 0:
            changed += 1
    if changed > 0:
        psv.stencil[buffer, block_row, block_column] += sample if z_pass else -sample
        _mark_others(places, footprint, block_row, block_column, psv.boundary[buffer], screen)
    accessed = cut or changed > 0
    if accessed:
        access(cache, buffer, block_row, block_column, True)
    return changed, accessed


@compiled
def _mark_others(places, footprint, block_row, block_column, boundary, screen):
    """Make those tiles of the block boundary tiles that are not among `places`."""
    place, end = places
    for row in range(2 * block_row, min(2 * block_row + 2, screen.rows)):
        for column in range(2 * block_column, min(2 * block_column + 2, screen.columns)):
            tile = row * screen.columns + column
            met = False
            for k in range(place, end):
                met = met or footprint.tile[k] == tile
            if not met:
                boundary[tile] = True
