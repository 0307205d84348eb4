"""Where a polygon lies on the screen: its pixels row by row, and the tiles that it meets.

An edge covers the rows from its upper end, included, to its lower end, excluded, and in each the pixels from where it
crosses the row. The two polygons that share an edge round it alike, so every pixel centre is on one side of it for
both; so the polygons of a closed volume cover each pixel as often from the front as from behind.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, inlined
from archsim.shadow_volumes.polygon import closeness_range
from archsim.shadow_volumes.tiles import Screen

MARGIN = 2.0**-16  # pixels by which a polygon counts as wider than it is when tiles are looked for

COUNTS, CUTS = (
    0,
    1,
)  # every pixel of the polygon in the tile passes the depth test, or some may; the others are dropped


class Footprint(NamedTuple):
    """Space for one polygon; every array is overwritten by the next. Only rows named by `Extent` mean something."""

    growing: (
        np.ndarray
    )  # int32 [height] first pixel right of the edge that grows in y: on the left of a front face
    shrinking: np.ndarray  # int32 [height] first pixel right of the other edge
    sample_growing: np.ndarray  # int32 [block rows] the same for the samples of tile blocks, in blocks
    sample_shrinking: np.ndarray  # int32 [block rows]
    left: np.ndarray  # float64 [tile rows] least x in the row of tiles
    right: np.ndarray  # float64 [tile rows] greatest
    tile: np.ndarray  # int32 [num_tiles] tiles met; those of one 2 x 2 block side by side
    relation: np.ndarray  # int8 [num_tiles] COUNTS or CUTS


class DepthTest(NamedTuple):
    """Which pixels a volume's polygons change."""

    z_pass: bool  # those that polygons are before, else those that they are behind
    least: float  # depth bounds: of tiles that show nothing as close as this, none
    greatest: float  # of tiles that show only what is closer, none


class Extent(NamedTuple):
    """Rows that a polygon reaches, as half-open ranges; `end_tile` is 0 where it misses the screen."""

    first: int  # pixel rows
    end: int
    first_sample: int  # rows of samples
    end_sample: int
    first_tile: int  # rows of tiles, MARGIN included
    end_tile: int


def new_footprint(screen: Screen) -> Footprint:
    """Space for the polygons of a screen."""
    block_rows = (screen.rows + 1) // 2
    num_tiles = screen.rows * screen.columns
    return Footprint(
        np.zeros(screen.height, np.int32),
        np.zeros(screen.height, np.int32),
        np.zeros(block_rows, np.int32),
        np.zeros(block_rows, np.int32),
        np.zeros(screen.rows),
        np.zeros(screen.rows),
        np.zeros(num_tiles, np.int32),
        np.zeros(num_tiles, np.int8),
    )


@compiled
def trace(corners, number, screen, footprint):
    """Fill the rows of a polygon; its Extent."""
    left, right, top, bottom = corners[0, 0], corners[0, 0], corners[0, 1], corners[0, 1]
    for corner in range(1, number):
        left, right = min(left, corners[corner, 0]), max(right, corners[corner, 0])
        top, bottom = min(top, corners[corner, 1]), max(bottom, corners[corner, 1])
    size = screen.tile
    first_tile = max(0, _first_tile(top, size))
    end_tile = min(screen.rows, _last_tile(bottom, size) + 1)
    if first_tile >= end_tile or right < -0.5 - MARGIN or left > screen.columns * size - 0.5 + MARGIN:
        return Extent(0, 0, 0, 0, 0, 0)

    for row in range(first_tile, end_tile):
        footprint.left[row], footprint.right[row] = np.inf, -np.inf
    for corner in range(number):
        _trace_edge(corners, corner, screen, footprint)
    block_rows = (screen.rows + 1) // 2
    return Extent(
        _at_or_after(top, screen.height),
        _at_or_after(bottom, screen.height),
        _at_or_after(_in_blocks(top, size), block_rows),
        _at_or_after(_in_blocks(bottom, size), block_rows),
        first_tile,
        end_tile,
    )


@compiled
def _trace_edge(corners, corner, screen, footprint):
    """Mark where the edge that starts at a corner crosses rows of pixels, of samples and of tiles."""
    grows = corners[corner + 1, 1] > corners[corner, 1]
    upper, lower = (corner, corner + 1) if grows else (corner + 1, corner)
    x, y = corners[upper, 0], corners[upper, 1]
    end_x, end_y = corners[lower, 0], corners[lower, 1]
    slope = (end_x - x) / (end_y - y) if end_y > y else 0.0
    size = screen.tile

    pixels = footprint.growing if grows else footprint.shrinking
    for row in range(_at_or_after(y, screen.height), _at_or_after(end_y, screen.height)):
        pixels[row] = _at_or_after(x + (row - y) * slope, screen.width)

    samples = footprint.sample_growing if grows else footprint.sample_shrinking
    block_rows, block_columns = (screen.rows + 1) // 2, (screen.columns + 1) // 2
    first, end = (
        _at_or_after(_in_blocks(y, size), block_rows),
        _at_or_after(_in_blocks(end_y, size), block_rows),
    )
    for row in range(first, end):
        crossing = x + (2 * size * row + size - 0.5 - y) * slope
        samples[row] = _at_or_after(_in_blocks(crossing, size), block_columns)

    least, greatest = min(x, end_x), max(x, end_x)
    for row in range(max(0, _first_tile(y, size)), min(screen.rows, _last_tile(end_y, size) + 1)):
        above = max(y, size * row - 0.5 - MARGIN)
        below = min(end_y, size * row + size - 0.5 + MARGIN)
        at_above, at_below = x + (above - y) * slope, x + (below - y) * slope
        if end_y == y:
            at_below = end_x
        footprint.left[row] = min(footprint.left[row], max(least, min(at_above, at_below)))
        footprint.right[row] = max(footprint.right[row], min(greatest, max(at_above, at_below)))


@compiled
def meet_tiles(extent, plane, test, screen, footprint):
    """Fill the tiles in which a polygon's pixels may pass the DepthTest; their number."""
    number = 0
    for block_row in range(extent.first_tile // 2, (extent.end_tile + 1) // 2):
        upper, lower = 2 * block_row, 2 * block_row + 1
        first_upper, end_upper = _columns(extent, upper, screen, footprint)
        first_lower, end_lower = _columns(extent, lower, screen, footprint)
        for block_column in range(min(first_upper, first_lower) // 2, (max(end_upper, end_lower) + 1) // 2):
            for column in range(2 * block_column, 2 * block_column + 2):
                if first_upper <= column < end_upper:
                    number = _meet(upper, column, plane, test, screen, footprint, number)
                if first_lower <= column < end_lower:
                    number = _meet(lower, column, plane, test, screen, footprint, number)
    return number


@compiled
def reached_tiles(extent, screen, footprint):
    """Tiles that a low-resolution rasterizer visits for the polygon."""
    number = 0
    for row in range(extent.first_tile, extent.end_tile):
        first, end = _columns(extent, row, screen, footprint)
        number += max(0, end - first)
    return number


@inlined
def _columns(extent, row, screen, footprint):
    """Half-open range of tile columns that the polygon reaches in a row of tiles."""
    if row < extent.first_tile or row >= extent.end_tile or footprint.left[row] > footprint.right[row]:
        return screen.columns, 0
    first = max(0, _first_tile(footprint.left[row], screen.tile))
    end = min(screen.columns, _last_tile(footprint.right[row], screen.tile) + 1)
    return first, end


@inlined
def _meet(row, column, plane, test, screen, footprint, number):
    """Add a tile if the polygon counts in it or cuts its box; the number of tiles then."""
    tile = row * screen.columns + column
    half = 0.5 * screen.tile
    x, y = column * screen.tile + half - 0.5, row * screen.tile + half - 0.5
    low, high = closeness_range(plane, x, y, half + MARGIN)
    is_behind, is_before = high <= screen.low[tile], low > screen.high[tile]
    if is_behind if test.z_pass else is_before:
        return number
    if screen.high[tile] < test.least or screen.low[tile] > test.greatest:
        return number
    footprint.tile[number] = tile
    footprint.relation[number] = COUNTS if is_behind or is_before else CUTS
    return number + 1


@inlined
def covers_sample(extent, footprint, block_row, block_column):
    """1 or -1 if the sample at the middle of a block of 2 x 2 tiles is covered, from the front or from behind; or 0."""
    if block_row < extent.first_sample or block_row >= extent.end_sample:
        return 0
    growing, shrinking = footprint.sample_growing[block_row], footprint.sample_shrinking[block_row]
    if growing <= block_column < shrinking:
        return 1
    return -1 if shrinking <= block_column < growing else 0


@inlined
def _at_or_after(coordinate, size):
    """The first whole number at or after the coordinate, within 0 ... size."""
    return int(min(max(np.ceil(coordinate), 0.0), size * 1.0))


@inlined
def _in_blocks(coordinate, size):
    """A pixel coordinate in units of blocks of 2 x 2 tiles, whose samples are at whole numbers."""
    return (coordinate - size + 0.5) / (2 * size)


@inlined
def _first_tile(coordinate, size):
    """The first tile that reaches the coordinate."""
    return int(np.ceil((coordinate + 0.5 - MARGIN) / size)) - 1


@inlined
def _last_tile(coordinate, size):
    return int(np.floor((coordinate + 0.5 + MARGIN) / size))
