"""Every sample of a mesh is hit exactly once, whatever the mesh, the map and f/n."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from archsim.lograster.clipping import MOST_CORNERS, clip
from archsim.lograster.evaluators import Design, with_rows
from archsim.lograster.grid import TILE, make_grid
from archsim.lograster.parameterization import largest_ratio
from archsim.lograster.setup import edge_functions, snap
from archsim.lograster.traversal import coarse, coverage

SIZES = st.sampled_from([8, 16, 24, 32])
RATIOS = st.one_of(st.just(1.0), st.floats(0, 1).map(lambda part: largest_ratio(32) ** part))


def hits(positions, triangles, grid):
    """How often each sample is hit by triangles over positions [n, 2] in map sizes: what the rasterizer says."""
    counts = np.zeros((len(grid.y), len(grid.x)), np.int64)
    tiles = np.empty((counts.size, 2), np.int32)
    for triangle in triangles:
        x, y = (tuple(int(snap(float(v), grid.bits)) for v in positions[triangle, axis]) for axis in (0, 1))
        edges = edge_functions(x, y)
        if edges.area == 0:
            continue
        found, _ = coarse(edges, x, y, grid, tiles)
        for row, column in tiles[:found]:
            mask = coverage(edges, grid, row, column)
            bits = np.array([mask >> bit & 1 for bit in range(TILE * TILE)]).reshape(TILE, TILE)
            counts[row * TILE : (row + 1) * TILE, column * TILE : (column + 1) * TILE] += bits
    return counts


def true_hits(positions, triangles, grid):
    """The same from first principles in whole numbers of any length: a sample on an edge belongs to the
    triangle
    that the point just right of and, infinitely less, above it is in."""
    counts = np.zeros((len(grid.y), len(grid.x)), np.int64)
    for triangle in triangles:
        corners = [[int(snap(float(v), grid.bits)) for v in positions[index]] for index in triangle]
        (x0, y0), (x1, y1), (x2, y2) = corners
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0:
            continue
        if area < 0:
            corners.reverse()
        for row, y in enumerate(grid.y.tolist()):
            for column, x in enumerate(grid.x.tolist()):
                counts[row, column] += all(
                    on_inner_side(a, b, x, y) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
                )
    return counts


def on_inner_side(a, b, x, y):
    """Left of the edge a b; the comparison of tuples is the infinitesimal step."""
    value = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
    return (value, a[1] - b[1], b[0] - a[0]) > (0, 0, 0)


@st.composite
def grids(draw):
    grid = make_grid(draw(SIZES), draw(SIZES), draw(RATIOS))
    return with_rows(grid, draw(st.sampled_from(Design)), 28)


@st.composite
def meshes(draw):
    """A net over the whole map and beyond: a jittered lattice whose outer vertices stay outside."""
    cells = draw(st.integers(1, 4))
    jitter = st.floats(-0.45, 0.45)
    lines = np.linspace(-0.3, 1.3, cells + 1)
    positions = np.array([(x, y) for y in lines for x in lines])
    for index in range(len(positions)):
        if abs(positions[index] - 0.5).max() < 0.5:
            positions[index] += np.array([draw(jitter), draw(jitter)]) * 1.6 / cells
    triangles = []
    for row in range(cells):
        for column in range(cells):
            a = row * (cells + 1) + column
            b, c, d = a + 1, a + cells + 1, a + cells + 2
            triangles += [(a, b, c), (b, d, c)] if draw(st.booleans()) else [(a, d, c), (a, b, d)]
    return positions, np.array(triangles)


@settings(max_examples=60, deadline=None)
@given(meshes(), grids())
def test_a_net_without_folds_hits_every_sample_once(mesh, grid):
    """Where jitter folds the net, signs count: front faces minus back faces is one everywhere."""
    positions, triangles = mesh
    front = turns(positions, triangles, grid) > 0

    covered = hits(positions, triangles[front], grid) - hits(positions, triangles[~front], grid)

    assert (covered == 1).all()


def turns(positions, triangles, grid):
    """The sign of each triangle's area after snapping."""
    whole = np.floor(positions * (1 << grid.bits) + 0.5).astype(object)
    a, b, c = (whole[triangles[:, i]] for i in range(3))
    areas = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    return np.array([int(area > 0) - int(area < 0) for area in areas])


@st.composite
def sample_fans(draw):
    """A fan around a sample, with corners on samples: edges run through samples, which are the hard cases."""
    grid = make_grid(8, 8, draw(RATIOS))
    place = st.tuples(st.integers(0, 7), st.integers(0, 7))
    corners = [draw(place) for _ in range(draw(st.integers(3, 5)))]
    scale = 1 << grid.bits
    positions = np.array([(grid.x[column] / scale, grid.y[row] / scale) for column, row in corners])
    triangles = [(0, i, i + 1) for i in range(1, len(corners) - 1)]
    return positions, np.array(triangles), grid


@settings(max_examples=60, deadline=None)
@given(sample_fans())
def test_samples_on_edges_and_corners_are_where_the_rule_puts_them(fan):
    positions, triangles, grid = fan

    assert np.array_equal(hits(positions, triangles, grid), true_hits(positions, triangles, grid))


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-4, 5, width=32), min_size=6, max_size=6), grids())
def test_coverage_is_exact_up_to_the_guard_band(numbers, grid):
    positions, triangles = np.array(numbers).reshape(3, 2), np.array([[0, 1, 2]])

    assert np.array_equal(hits(positions, triangles, grid), true_hits(positions, triangles, grid))


@settings(max_examples=80, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-20, 20)] * 3, st.floats(-2, 5)), min_size=4, max_size=4))
@example([(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, -1.0, 1.0)])
def test_an_edge_is_cut_at_the_same_points_from_both_sides(vertices):
    """Two triangles share the edge 0 1: what is left of it has the same ends in both polygons, to the bit."""
    vertices = np.array(vertices)
    for third in (2, 3):
        spanned = np.linalg.svd(vertices[[1, third]] - vertices[0], compute_uv=False)
        assume(spanned[-1] > 0.1)

    assert on_edge(clipped(vertices[[0, 1, 2]]), vertices) == on_edge(clipped(vertices[[1, 0, 3]]), vertices)
    assert on_edge(clipped(vertices[[1, 2, 0]]), vertices) == on_edge(clipped(vertices[[3, 1, 0]]), vertices)


def clipped(corners):
    polygon = np.empty((MOST_CORNERS, 4))
    num = clip(np.ascontiguousarray(corners), 1e-9, polygon, np.empty((MOST_CORNERS, 4)))
    return polygon[:num]


def on_edge(polygon, vertices):
    """Corners of the polygon on the line through vertices 0 and 1; those of a cut at 1e-9 lie farther from it."""
    direction = (vertices[1] - vertices[0]) / np.linalg.norm(vertices[1] - vertices[0])
    offsets = polygon - vertices[0]
    beside = offsets - np.outer(offsets @ direction, direction)
    return {tuple(corner) for corner in polygon[np.abs(beside).max(axis=1, initial=0.0) < 1e-12]}


def test_the_test_can_fail():
    """With an edge that belongs to both sides, the samples on it are hit twice."""
    grid = make_grid(8, 8)
    positions = np.array([(0.0625, 0.0625), (0.9375, 0.9375), (0.0625, 0.9375), (0.9375, 0.0625)])
    counts = hits(positions, np.array([(0, 1, 2), (0, 1, 3)]), grid)

    assert counts.max() == 1
    assert (np.diagonal(counts)[:-1] == 1).all()


@pytest.mark.parametrize("ratio", [1.0, 30.0, 32768.0])
def test_a_tile_s_corners_never_hide_a_sample(ratio):
    """Coarse tests drop no tile with coverage: counts with and without them agree on slivers."""
    random = np.random.default_rng(5)
    grid = make_grid(64, 64, ratio)
    for _ in range(30):
        positions = random.uniform(-0.2, 1.2, (3, 2))
        positions[2] = positions[0] + 0.03 * random.normal(size=2)
        triangles = np.array([[0, 1, 2]])
        assert np.array_equal(hits(positions, triangles, grid), true_hits(positions, triangles, grid))
