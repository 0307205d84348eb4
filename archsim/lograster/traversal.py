"""Coarse and fine rasterization: which 4 x 4 tiles a triangle reaches, and which of their samples it owns.
[Lloyd07] sec. 4.1, 4.2

Edge functions stay monotonic in column and row when rows are spaced logarithmically, so their values at the
corners of a block of samples still bound those inside, and steer the traversal exactly as on a linear map.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import njit
from archsim.lograster.grid import TILE

REGION = 8  # tiles along each side of what one coarse test can reject


@njit
def coarse(edges, x, y, grid, tiles):
    """Write the tiles (row, column) that a triangle reaches to `tiles`, int32 [n, 2]; x, y are its whole
    corner coordinates.

    Regions row by row, in each the tiles row by row. Returns (number of tiles, number of corner tests).
    """
    first_column, end_column = _tile_range(grid.x, min(x[0], x[1], x[2]), max(x[0], x[1], x[2]))
    first_row, end_row = _tile_range(grid.y, min(y[0], y[1], y[2]), max(y[0], y[1], y[2]))
    num_tiles = 0
    num_tests = 0
    for region_row in range(first_row // REGION, -(-end_row // REGION)):
        row0, row1 = max(first_row, region_row * REGION), min(end_row, (region_row + 1) * REGION)
        for region_column in range(first_column // REGION, -(-end_column // REGION)):
            column0 = max(first_column, region_column * REGION)
            column1 = min(end_column, (region_column + 1) * REGION)
            num_tests += 1
            if not reaches(edges, grid, row0, column0, row1, column1):
                continue
            for row in range(row0, row1):
                for column in range(column0, column1):
                    num_tests += 1
                    if reaches(edges, grid, row, column, row + 1, column + 1):
                        tiles[num_tiles, 0] = row
                        tiles[num_tiles, 1] = column
                        num_tiles += 1
    return num_tiles, num_tests


@njit
def _tile_range(positions, low, high):
    """Tiles first <= i < end that hold the samples from coordinate `low` to `high`."""
    first = np.searchsorted(positions, low)
    end = np.searchsorted(positions, high, side="right")
    if first >= end:
        return 0, 0
    return first // TILE, -(-end // TILE)


@njit
def reaches(edges, grid, row0, column0, row1, column1):
    """Whether no edge leaves out all the corner samples of a block of tiles (ends excluded)."""
    left, right = grid.x[column0 * TILE], grid.x[column1 * TILE - 1]
    low, high = grid.y[row0 * TILE], grid.y[row1 * TILE - 1]
    for i in range(3):
        a, b = edges.a[i], edges.b[i]
        if a * (right if a > 0 else left) + b * (high if b > 0 else low) + edges.c[i] < 0:
            return False
    return True


@njit
def coverage(edges, grid, row, column):
    """The 16 samples of a tile that the triangle owns: bit 4 i + k for sample (row i, column k) of the tile.

    Each edge is evaluated in full in the tile's first column; the others follow by adding. [Lloyd07] eq. 4, 6
    """
    mask = 0xFFFF
    first = column * TILE
    for i in range(3):
        a, c = edges.a[i], edges.c[i]
        for in_row in range(TILE):
            value = a * grid.x[first] + edges.b[i] * grid.y[row * TILE + in_row] + c
            for in_column in range(TILE):
                if value < 0:
                    mask &= ~(1 << (TILE * in_row + in_column))
                if in_column + 1 < TILE:
                    value += a * (grid.x[first + in_column + 1] - grid.x[first + in_column])
    return mask
