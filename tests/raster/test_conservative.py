"""Conservative rasterization against exact overlap."""

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.raster.conservative import Setup, Viewport, populated, rasterize

points = st.tuples(st.integers(-12, 40), st.integers(-12, 40))


def setup(*triangles):
    """Setup of counter-clockwise or clockwise triangles in cell coordinates."""
    edges, bounds = [], []
    for triangle in triangles:
        v = np.array([(x, y, 1.0) for x, y in triangle])
        crosses = np.cross(np.roll(v, -1, axis=0), np.roll(v, -2, axis=0))
        edges.append(crosses * np.sign(v[0] @ crosses[0]))
        bounds.append((*v[:, :2].min(axis=0), *v[:, :2].max(axis=0)))
    return Setup(np.arange(len(triangles), dtype=np.int32), np.array(edges), np.array(bounds, dtype=float))


def cells(fragments):
    return list(zip(fragments.i.tolist(), fragments.j.tolist(), strict=True))


def overlaps(triangle, i, j):
    """Whether the closed triangle meets the closed cell, exactly: clip it and see what is left."""
    polygon = [(Fraction(x), Fraction(y)) for x, y in triangle]
    for axis, bound, sign in ((0, i, 1), (0, i + 1, -1), (1, j, 1), (1, j + 1, -1)):
        clipped = []
        for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
            da, db = sign * (a[axis] - bound), sign * (b[axis] - bound)
            if da >= 0:
                clipped.append(a)
            if da * db < 0:
                t = da / (da - db)
                clipped.append((a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))
        polygon = clipped
    return bool(polygon)


@given(st.tuples(points, points, points))
@settings(max_examples=60, deadline=None)
def test_exactly_the_overlapped_cells(triangle):
    (x0, y0), (x1, y1), (x2, y2) = triangle
    if (x1 - x0) * (y2 - y0) == (x2 - x0) * (y1 - y0):
        return
    stencil = np.ones((32, 32), np.bool_)
    found = set(cells(rasterize(setup(triangle), stencil, (8, 8), 0.0)))
    assert found == {(i, j) for i in range(32) for j in range(32) if overlaps(triangle, i, j)}


def test_a_sliver_between_cell_centres_is_found():
    found = cells(
        rasterize(setup([(0.1, 0.1), (3.9, 0.15), (0.1, 0.2)]), np.ones((4, 4), np.bool_), (4, 4), 0.0)
    )
    assert found == [(0, 0), (1, 0), (2, 0), (3, 0)]


def test_order_is_tile_by_tile_and_triangle_by_triangle():
    square = [(0, 0), (4, 0), (0, 4)]
    fragments = rasterize(setup(square, square), np.ones((4, 4), np.bool_), (2, 2), -0.01)
    one = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (3, 0), (2, 1), (0, 2), (1, 2), (0, 3)]
    assert cells(fragments) == one + one
    assert fragments.setup_index.tolist() == [0] * 10 + [1] * 10


def test_the_stencil_discards_and_the_viewport_clips():
    stencil = np.zeros((8, 8), np.bool_)
    stencil[2, 3] = stencil[5, 6] = True
    assert populated(stencil) == Viewport(3, 2, 7, 6)
    fragments = rasterize(setup([(-9, -9), (30, -9), (-9, 30)]), stencil, (4, 4), 0.0)
    assert cells(fragments) == [(3, 2), (6, 5)]
    assert fragments.num_before_stencil == 16


def test_nothing_comes_of_nothing():
    empty = Setup(np.empty(0, np.int32), np.empty((0, 3, 3)), np.empty((0, 4)))
    assert len(rasterize(empty, np.ones((4, 4), np.bool_), (2, 2), 0.0).i) == 0
    nowhere = rasterize(setup([(0, 0), (4, 0), (0, 4)]), np.zeros((4, 4), np.bool_), (2, 2), 0.0)
    assert (len(nowhere.i), nowhere.num_before_stencil) == (0, 0)


def test_a_triangle_through_the_light_plane_meets_the_whole_viewport_it_covers():
    """Infinite bounds leave everything to the edge functions."""
    ours = setup([(0, 0), (4, 0), (0, 4)])
    infinite = ours._replace(bounds=np.array([[-np.inf, -np.inf, np.inf, np.inf]]))
    stencil = np.ones((4, 4), np.bool_)
    assert cells(rasterize(infinite, stencil, (2, 2), -0.01)) == cells(
        rasterize(ours, stencil, (2, 2), -0.01)
    )
