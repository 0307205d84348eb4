"""What low-resolution rasterizer and early occlusion test hand to a stage: triangles in blocks of 2 x 2 tiles.

The tiles of a block stand column by column: left above, left below, right above, right below.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, njit
from archsim.shadow_volumes.footprint import CUTS, DepthTest, covers_sample, meet_tiles, trace
from archsim.shadow_volumes.polygon import plane_of, project
from archsim.shadow_volumes.seen import SeenVolumes, Space
from archsim.shadow_volumes.stage1 import block_end
from archsim.shadow_volumes.stencil import draw_tile

PASSES, NOT_MET, CUT = -1, 0, 1  # all pixels of the triangle in the tile pass the depth test; none; some may


class Blocks(NamedTuple):
    """Triangles of one volume, in all blocks that they meet."""

    triangle: np.ndarray  # int32 [n]
    row: np.ndarray  # int32 [n] of the block
    column: np.ndarray  # int32 [n]
    relation: np.ndarray  # int8 [n, 4] of each tile: PASSES, NOT_MET or CUT
    operation: np.ndarray  # int8 [n] on the stencil value of the block's sample; 0 if it is not covered


@njit
def count_blocks(seen, space):
    """int64 [num_triangles]: blocks that each triangle meets."""
    volumes, screen, footprint = seen.volumes, seen.screen, space.footprint
    counts = np.zeros(len(volumes.triangles), np.int64)
    for volume in range(len(seen.bounds)):
        for index in range(volumes.starts[volume], volumes.starts[volume + 1]):
            met, _ = _meet(index, volume, seen, space)
            place = 0
            while place < met:
                place = block_end(footprint, place, met, screen)
                counts[index] += 1
    return counts


def blocks_of(
    volume: int, triangles: tuple[int, int], number: int, seen: SeenVolumes, space: Space
) -> Blocks:
    """Triangles (first, end) of a volume; they meet `number` blocks."""
    triangle, row, column = (np.zeros(number, np.int32) for _ in range(3))
    relation, operation = np.full((number, 4), NOT_MET, np.int8), np.zeros(number, np.int8)
    blocks = Blocks(triangle, row, column, relation, operation)
    _fill(volume, triangles, seen, space, blocks)
    return blocks


@njit
def _fill(volume, triangles, seen, space, blocks):
    screen, footprint = seen.screen, space.footprint
    number = 0
    for index in range(triangles[0], triangles[1]):
        met, shape = _meet(index, volume, seen, space)
        place = 0
        while place < met:
            end = block_end(footprint, place, met, screen)
            is_undrawn = index < seen.volumes.drawn[volume]
            _fill_block((place, end), (index, is_undrawn), shape, screen, blocks, number)
            number += 1
            place = end


@compiled
def _fill_block(places, triangle, shape, screen, blocks, number):
    """Block `number`, whose tiles are at half-open `places` in the footprint. triangle: (index, whether undrawn)."""
    index, is_undrawn = triangle
    footprint, extent, _, z_pass = shape
    row, column = footprint.tile[places[0]] // screen.columns, footprint.tile[places[0]] % screen.columns
    blocks.triangle[number] = index
    blocks.row[number], blocks.column[number] = row // 2, column // 2
    sample = covers_sample(extent, footprint, row // 2, column // 2)
    blocks.operation[number] = 0 if is_undrawn else sample if z_pass else -sample
    for k in range(places[0], places[1]):
        row, column = footprint.tile[k] // screen.columns, footprint.tile[k] % screen.columns
        blocks.relation[number, 2 * (column % 2) + row % 2] = (
            CUT if footprint.relation[k] == CUTS or (is_undrawn and sample != 0) else PASSES
        )


@njit
def _meet(index, volume, seen, space):
    """Fill the footprint with a triangle of a volume: (tiles met, shape as `draw_tile` wants it)."""
    polygon, footprint = space
    test = DepthTest(seen.volumes.z_pass[volume], seen.bounds[volume, 0], seen.bounds[volume, 1])
    number = project(seen.points, seen.volumes.triangles[index], seen.screen.frustum, polygon)
    extent = trace(polygon.corners, number, seen.screen, footprint)
    plane = plane_of(polygon.corners, number)
    met = meet_tiles(extent, plane, test, seen.screen, footprint) if number > 0 else 0
    return met, (footprint, extent, plane, test.z_pass)


def tiles_of(blocks: Blocks, columns: int) -> np.ndarray:
    """int64 [n, 4]: numbers of the tiles of blocks on a screen with so many columns of tiles."""
    row, column = 2 * blocks.row.astype(np.int64), 2 * blocks.column.astype(np.int64)
    upper = row * columns + column
    return np.stack([upper, upper + columns, upper + 1, upper + columns + 1], axis=1)


@njit
def draw_tiles(volume, triangle, tile, seen, space, stencil):
    """Draw triangles of a volume in tiles, int64 [n] each, in the order of `Blocks`: (pixels updated, depth tiles)."""
    screen, footprint = seen.screen, space.footprint
    pixels, depth_tiles, place = 0, 0, 0
    while place < len(tile):
        index = triangle[place]
        met, shape = _meet(index, volume, seen, space)
        for k in range(met):
            if place < len(tile) and triangle[place] == index and tile[place] == footprint.tile[k]:
                updated, fetched = draw_tile(tile[place], footprint.relation[k], shape, screen, stencil)
                pixels += updated
                depth_tiles += fetched
                place += 1
    return pixels, depth_tiles
