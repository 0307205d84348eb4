"""Draws triangles into a buffer of whole depths, tile by tile: the functional model of the rasterizer.
[Lloyd07] sec. 4
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.lograster.clipping import MOST_CORNERS, clip
from archsim.lograster.grid import TILE, Grid
from archsim.lograster.offset import OffsetSpec, Switch, excess, offset_depth, offset_depth_at, slopes
from archsim.lograster.parameterization import unwarp_slope
from archsim.lograster.setup import depth_plane, edge_functions, snap
from archsim.lograster.traversal import coarse, coverage

DEPTH_BITS = 24
FARTHEST = (1 << DEPTH_BITS) - 1  # also what an untouched sample holds
LEAST_W = 1e-9  # of the mesh's largest |w|: nearer to w = 0 nothing is drawn
NO_OFFSET = OffsetSpec(0.0, 0.0, int(Switch.INTERPOLATED))


class Buffer(NamedTuple):
    """A shadow map while triangles are drawn into it."""

    depth: np.ndarray  # int32 [rows, columns]
    layers: np.ndarray  # int32 [rows, columns] fragments of each sample so far
    touched: np.ndarray  # bool [tile rows, tile columns]


class Drawn(NamedTuple):
    """A shadow map and how it came about."""

    depth: np.ndarray  # int32 [rows, columns] 0 nearest to the light; beyond that is clamped to 0
    touched: np.ndarray  # bool [tile rows, tile columns] tiles with a sample that passed the depth test
    layers: np.ndarray  # int64 [most + 1] samples by the number of their fragments: the depth complexity
    counts: DrawCounts


class DrawCounts(NamedTuple):
    """Sums over all triangles; each row's comment is what is counted."""

    triangles: int  # after clipping, those that reach a tile
    corner_tests: int  # coarse tests of regions and tiles
    tiles: int  # (triangle, tile) pairs that passed the coarse test
    covered_tiles: int  # of those, with at least one sample inside
    fragments: int  # samples inside
    passed: int  # fragments nearer than what was there
    switches: int  # triangles within which the larger slope changes
    excess_sum: float  # over those, the most that the interpolated slope exceeds the true one, relative
    excess_most: float  # the largest of these


def draw(vertices: np.ndarray, triangles: np.ndarray, grid: Grid, offset: OffsetSpec = NO_OFFSET) -> Drawn:
    """The depth buffer of triangles int32 [n, 3] over vertices (x, y, z, w) float64 [m, 4]; the nearest depth
    wins.

    (x/w, y/w) in [0, 1] is the place in the map, linear in y; z/w in [0, 1] the depth, clamped outside.
    """
    rows, columns = len(grid.y), len(grid.x)
    buffer = Buffer(
        depth=np.full((rows, columns), FARTHEST, dtype=np.int32),
        layers=np.zeros((rows, columns), dtype=np.int32),
        touched=np.zeros((rows // TILE, columns // TILE), dtype=np.bool_),
    )
    corners = np.ascontiguousarray(vertices, dtype=np.float64)
    counts = _draw(corners, triangles, grid, steepness(grid), offset, buffer)
    return Drawn(buffer.depth, buffer.touched, np.bincount(buffer.layers.ravel()), DrawCounts(*counts))


def steepness(grid: Grid) -> tuple[float, float]:
    """(dy/dy' at y = 0, its change up to y = 1) of the grid's rows. [Lloyd07] eq. 13"""
    start, end = unwarp_slope(np.array([0.0, 1.0]), grid.ratio)
    return float(start), float(end - start)


@njit
def _draw(vertices, triangles, grid, steep, offset, buffer):
    """Draw in order; returns the fields of DrawCounts."""
    polygon, spare = np.empty((MOST_CORNERS, 4)), np.empty((MOST_CORNERS, 4))
    tiles = np.empty((buffer.touched.size, 2), np.int32)
    corners = np.empty((3, 4))
    least_w = LEAST_W * np.max(np.abs(vertices[:, 3])) if len(vertices) else 1.0
    num_triangles = num_tests = num_tiles = num_covered = num_fragments = num_passed = num_switches = 0
    excess_sum = excess_most = 0.0
    for index in range(len(triangles)):
        for i in range(3):
            corners[i] = vertices[triangles[index, i]]
        for i in range(1, clip(corners, least_w, polygon, spare) - 1):
            x, y, z = fan_triangle(polygon, i)
            whole_x, whole_y = snapped(x, grid.bits), snapped(y, grid.bits)
            edges = edge_functions(whole_x, whole_y)
            if edges.area == 0:
                continue
            found, tests = coarse(edges, whole_x, whole_y, grid, tiles)
            num_tests += tests
            num_tiles += found
            if found == 0:
                continue
            num_triangles += 1
            plane, over = offset_plane(x, y, z, grid, steep, offset)
            if over > 0:
                num_switches += 1
                excess_sum += over
                excess_most = max(excess_most, over)
            for k in range(found):
                mask = coverage(edges, grid, tiles[k, 0], tiles[k, 1])
                if mask:
                    inside, passed = _test_depths(mask, plane, tiles[k], grid, buffer)
                    num_covered += 1
                    num_fragments += inside
                    num_passed += passed
                    buffer.touched[tiles[k, 0], tiles[k, 1]] |= passed > 0
    return (
        num_triangles,
        num_tests,
        num_tiles,
        num_covered,
        num_fragments,
        num_passed,
        num_switches,
        excess_sum,
        excess_most,
    )


@njit
def fan_triangle(polygon, i):
    """Corner positions (x[3], y[3], z[3]) in the map of triangle i of a polygon's fan."""
    a, b, c = polygon[0], polygon[i], polygon[i + 1]
    return (
        (a[0] / a[3], b[0] / b[3], c[0] / c[3]),
        (a[1] / a[3], b[1] / b[3], c[1] / c[3]),
        (a[2] / a[3], b[2] / b[3], c[2] / c[3]),
    )


@njit
def snapped(positions, bits):
    """The whole coordinates of three corners."""
    return snap(positions[0], bits), snap(positions[1], bits), snap(positions[2], bits)


@njit
def offset_plane(x, y, z, grid, steep, offset):
    """(OffsetDepth of a triangle, how far the interpolated slope exceeds the true one at most)."""
    plane = depth_plane(x, y, z)
    low, high = max(0.0, min(y[0], y[1], y[2])), min(1.0, max(y[0], y[1], y[2]))
    inclination = slopes(plane, len(grid.x), len(grid.y), steep)
    return offset_depth(plane, inclination, low, high, offset), excess(inclination, low, high)


@njit
def whole_depth(depth):
    """A depth as it is stored."""
    return int(min(max(depth, 0.0), 1.0) * FARTHEST + 0.5)


@njit
def sample_depth(plane, grid, row, column):
    """The stored depth of an OffsetDepth at a sample."""
    scale = 1.0 / (1 << grid.bits)
    return whole_depth(offset_depth_at(plane, grid.x[column] * scale, grid.y[row] * scale))


@njit
def _test_depths(mask, plane, tile, grid, buffer):
    """Depth test of the covered samples of a tile; (fragments, those that passed)."""
    inside = passed = 0
    for i in range(TILE):
        for k in range(TILE):
            if mask >> (TILE * i + k) & 1:
                inside += 1
                row, column = tile[0] * TILE + i, tile[1] * TILE + k
                here = sample_depth(plane, grid, row, column)
                buffer.layers[row, column] += 1
                if here < buffer.depth[row, column]:
                    buffer.depth[row, column] = here
                    passed += 1
    return inside, passed
