"""The z-prepass against pictures worked out by hand, and its promise that no pixel falls between triangles."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from archsim.raster.eye_view import eye_view
from archsim.scene.camera import Camera, pixel_rays
from archsim.scene.mesh import Mesh, load_mesh

# Looks along y with z up; at 90 degrees the image of the plane y = 1 is -1 .. 1 in x and z.
NORTH = Camera(np.zeros(3), np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), 90.0, 0.1)


def soup(*triangles):
    """A mesh of triangles that share no vertices."""
    corners = np.array(triangles, dtype=np.float32).reshape(-1, 3)
    return Mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))


def facing(depth, corners=((-9, -9), (9, -9), (0, 9))):
    """A triangle in the plane y = depth with corners (x, z)."""
    return [(x, depth, z) for x, z in corners]


def test_half_an_image_pixel_by_pixel():
    picture = eye_view(soup(facing(1, [(-1, -1), (1, -1), (-1, 1)])), NORTH, 8, 8)
    below_diagonal = np.tril(
        np.ones((8, 8), dtype=bool)
    )  # pixel centres on the diagonal are on the edge: inside
    np.testing.assert_array_equal(picture.triangle, np.where(below_diagonal, 0, -1))
    np.testing.assert_array_equal(picture.covered, below_diagonal)
    np.testing.assert_array_equal(np.isnan(picture.reciprocal_depth), ~below_diagonal)
    np.testing.assert_allclose(picture.reciprocal_depth[below_diagonal], 1)
    dtypes = [array.dtype for array in picture]
    assert dtypes == [np.float32, np.int32, np.int32]


def test_corners_at_pixel_centres_are_inside():
    """In an image of 8 x 8 the four pixels in the middle have their centres at -0.125 and 0.125."""
    picture = eye_view(soup(facing(1, [(-0.125, -0.125), (0.125, -0.125), (0.125, 0.125)])), NORTH, 8, 8)
    assert set(zip(*np.nonzero(picture.covered), strict=True)) == {(4, 3), (4, 4), (3, 4)}


def test_up_is_up_and_right_is_right():
    picture = eye_view(soup(facing(2, [(0.5, 0.5), (2, 0.5), (0.5, 2)])), NORTH, 8, 4)
    rows, columns = np.nonzero(picture.triangle == 0)
    assert rows.max() < 2
    assert columns.min() >= 4


def test_depth_is_perspective_correct():
    """The plane y = 2 + x has, along direction (X, 1, Z), the depth 2 / (1 - X)."""
    picture = eye_view(soup([(-1.9, 0.1, -9), (40, 42, -90), (-0.5, 1.5, 90)]), NORTH, 16, 12)
    rays = pixel_rays(NORTH, 16, 12)
    x = rays.corner[0] + np.arange(16) * rays.step_x[0]
    expected = np.broadcast_to((1 - x) / 2, (12, 16))
    seen = picture.triangle == 0
    assert 40 < seen.sum() < 192
    np.testing.assert_allclose(picture.reciprocal_depth[seen], expected[seen], rtol=1e-6)


@pytest.mark.parametrize("near", [0.1, 1.9])
def test_a_floor_that_passes_under_the_eye(near):
    """The floor z = -1 is seen in direction (X, 1, Z) at depth -1 / Z, if that is not before the near plane."""
    floor = soup([(-9e3, -9e3, -1), (9e3, -9e3, -1), (0, 9e6, -1)])
    picture = eye_view(floor, NORTH._replace(near=near), 10, 10)
    z = 0.9 - 0.2 * np.arange(10)
    expected = np.broadcast_to((z < 0) & (-1 / z >= near), (10, 10)[::-1]).T
    np.testing.assert_array_equal(picture.triangle == 0, expected)
    depths = picture.reciprocal_depth[expected]
    np.testing.assert_allclose(depths, np.broadcast_to(-z[:, None], (10, 10))[expected], rtol=1e-6)


def test_the_nearest_is_seen_and_all_are_counted():
    picture = eye_view(soup(facing(3), facing(2), facing(4), facing(0.05), facing(-2)), NORTH, 4, 4)
    assert (picture.triangle == 1).all()
    assert (picture.covered == 3).all()
    np.testing.assert_allclose(picture.reciprocal_depth, 0.5)


def test_of_equally_near_triangles_the_lower_is_seen():
    assert (eye_view(soup(facing(5), facing(3), facing(3)), NORTH, 4, 4).triangle == 1).all()


def test_of_coplanar_triangles_the_lower_is_seen_whatever_the_rounding():
    """Their depths, computed from other corners, differ in the last bits."""
    random = np.random.default_rng(3)
    mesh = soup(*(np.append(random.uniform(-5, 5, (3, 2)), np.full((3, 1), -1), axis=1) for _ in range(9)))
    camera = Camera(np.array([0.3, -4.1, 2.7]), np.array([0.1, 0.2, -1]), np.array([0.0, 0, 1]), 70.0, 0.1)
    alone = [eye_view(mesh._replace(triangles=mesh.triangles[i : i + 1]), camera, 64, 48) for i in range(9)]
    covers = np.array([picture.covered > 0 for picture in alone])
    assert (covers.sum(axis=0) > 1).mean() > 0.05
    expected = np.where(covers.any(axis=0), covers.argmax(axis=0), -1)
    np.testing.assert_array_equal(eye_view(mesh, camera, 64, 48).triangle, expected)


def test_depth_exactly_near_is_kept():
    assert (eye_view(soup(facing(2)), NORTH._replace(near=2.0), 4, 4).triangle == 0).all()


def test_both_sides_are_seen():
    one, other = facing(1, [(-1, -1), (1, -1), (-1, 1)]), facing(1, [(-1, -1), (-1, 1), (1, -1)])
    first, second = eye_view(soup(one), NORTH, 8, 8), eye_view(soup(other), NORTH, 8, 8)
    for mine, theirs in zip(first, second, strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize(
    "unseen",
    [
        [],
        [facing(-1)],  # behind
        [[(0, 0.5, 0), (0, 3, 1), (0, 3, -1)]],  # edge-on, across the middle of an odd image
        [[(0, 1, 0), (0, 1, 0), (0, 1, 0)]],  # a point
        [[(0, 1, 0), (1, 2, 1), (2, 3, 2)]],  # a line
        [facing(1, [(3, 0), (4, 0), (3, 1)])],  # to the right
        [facing(1, [(0, 3), (1, 3), (0, 4)])],  # above
        [[(0, 0, 0), (1, -1, 0), (0, -1, 1)]],  # touches the eye from behind
    ],
)
def test_what_is_not_seen(unseen):
    picture = eye_view(soup(*unseen), NORTH, 5, 5)
    assert (picture.triangle == -1).all()
    assert (picture.covered == 0).all()
    assert np.isnan(picture.reciprocal_depth).all()


def test_an_image_of_one_pixel():
    assert eye_view(soup(facing(4)), NORTH, 1, 1).reciprocal_depth.item() == 0.25


BOX = Mesh(
    np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float32),
    np.array(
        [c for a, b, c, d in
         [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
         for c in ((a, b, c), (a, c, d))],
        dtype=np.int32,
    ),
)  # fmt: skip

direction = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: max(map(abs, d)) > 0.1)
inside = st.tuples(*[st.floats(-0.9, 0.9)] * 3)


@settings(max_examples=60, deadline=None)
@given(eye=inside, towards=direction, fovy=st.floats(5, 150), power=st.integers(-30, 30))
def test_inside_a_closed_box_every_pixel_sees_one_wall(eye, towards, fovy, power):
    scale = np.float32(2.0**power)
    up = np.roll(towards, 1) * (1, -1, 0.5)
    assume(np.linalg.norm(np.cross(towards, up)) > 0.05)
    camera = Camera(np.array(eye) * scale, (np.array(eye) + towards) * scale, up, fovy, 1e-6 * float(scale))
    picture = eye_view(BOX._replace(vertices=BOX.vertices * scale), camera, 23, 17)
    assert (picture.covered >= 1).all()
    assert (picture.covered > 1).mean() <= 0.2  # only pixels exactly on an edge are covered twice
    assert np.isfinite(picture.reciprocal_depth).all()


def grid(columns, rows, shift, shared):
    """A sheet of (columns x rows) cut quads around (0, 1, 0), its inner vertices moved by shift [n, 3]."""
    x, z = np.meshgrid(np.linspace(-2, 2, columns + 1), np.linspace(-2, 2, rows + 1))
    vertices = np.stack([x.ravel(), np.ones(x.size), z.ravel()], axis=1)
    vertices = (vertices + shift[: len(vertices)]).astype(np.float32)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    a, b, c, d = first, first + 1, first + columns + 2, first + columns + 1
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, d, c], 1)]).astype(np.int32)
    return Mesh(vertices, triangles) if shared else soup(*vertices[triangles])


@settings(max_examples=60, deadline=None)
@given(
    size=st.tuples(st.integers(1, 9), st.integers(1, 9)),
    shake=st.sampled_from([0.0, 0.15]),
    shared=st.booleans(),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_pixel_falls_between_the_triangles_of_a_sheet(size, shake, shared, seed):
    """Unshaken, most edges of the sheet pass exactly through pixel centres."""
    shift = np.random.default_rng(seed).uniform(-shake, shake, (100, 3))
    picture = eye_view(grid(*size, shift, shared), NORTH, 24, 24)
    assert (picture.triangle >= 0).all()


@settings(max_examples=40, deadline=None)
@given(corners=st.integers(3, 40), seed=st.integers(0, 2**32 - 1))
def test_no_pixel_falls_between_the_triangles_of_a_fan(corners, seed):
    """All triangles meet in a point, which is at a pixel's centre; slivers among them."""
    angle = np.sort(np.random.default_rng(seed).uniform(0, 2 * np.pi, corners))
    angle = np.concatenate([angle, [0, 2, 4]])
    angle.sort()
    rim = np.stack([9 * np.cos(angle), np.ones(len(angle)), 9 * np.sin(angle)], axis=1)
    middle = np.array([(0, 1, 0)])
    ring = np.arange(len(rim))
    triangles = np.stack([ring, np.roll(ring, -1), np.full(len(rim), len(rim))], axis=1)
    mesh = Mesh(np.concatenate([rim, middle]).astype(np.float32), triangles.astype(np.int32))
    assert (eye_view(mesh, NORTH, 21, 21).triangle >= 0).all()


@pytest.mark.parametrize("scale", [1e-30, 1e-10, 1e10, 1e30])
def test_scale_does_not_matter(scale):
    mesh = soup(facing(3), facing(2, [(-1, -1), (1, -1), (0, 1)]), [(-1, -1, -1), (1, -1, -1), (0, 9, -1)])
    scaled = mesh._replace(vertices=mesh.vertices * np.float32(scale))
    plain = eye_view(mesh, NORTH, 33, 31)
    other = eye_view(scaled, NORTH._replace(near=0.1 * scale), 33, 31)
    assert set(np.unique(plain.triangle)) == {-1, 0, 1, 2}
    assert (plain.triangle != other.triangle).mean() < 0.003
    same = plain.triangle == other.triangle
    np.testing.assert_allclose(other.reciprocal_depth[same] * scale, plain.reciprocal_depth[same], rtol=1e-5)


def test_the_extremes_of_float32_do_no_harm():
    largest = np.finfo(np.float32).max
    triangles = [facing(largest, [(-largest, -largest), (largest, -largest), (0, largest)]), facing(1e-45)]
    picture = eye_view(soup(*triangles), NORTH, 9, 9)
    assert (picture.triangle == 0).any()


def test_a_level_is_full_of_geometry():
    """Pixels and depth complexity of an indoor view, as first measured; the ray tracer agrees pixel by pixel."""
    eye, target = np.array([2054.4, 2246.4, 12.0]), np.array([2053.4, 2246.4, 11.92])
    camera = Camera(eye, target, np.array([0.0, 0, 1]), 75.0, 2.0)
    picture = eye_view(load_mesh("nx_bloodprison_8k9"), camera, 160, 128)
    assert (picture.triangle >= 0).all()
    assert picture.covered.mean() == pytest.approx(2.41, abs=0.02)
