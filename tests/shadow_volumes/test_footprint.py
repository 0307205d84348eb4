"""Polygons on the screen: clipping, pixels covered, tiles met."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.shadow_volumes.footprint import CUTS, DepthTest, covers_sample, meet_tiles, new_footprint, trace
from archsim.shadow_volumes.polygon import Frustum, closeness, closeness_range, new_polygon, plane_of, project
from archsim.shadow_volumes.tiles import screen

WIDTH, HEIGHT = 37, 29
Z_FAIL = DepthTest(False, 0.0, np.inf)


def flat_screen(closest=0.5, tile=8):
    return screen(np.full((HEIGHT, WIDTH), closest, np.float32), 0.1, tile)


def seen_triangle(corners, depths):
    """Homogeneous points of a triangle with corners (x, y) on the screen and a closeness each."""
    return np.array([(x / c, y / c, 1 / c, 1.0) for (x, y), c in zip(corners, depths, strict=True)])


def coverage(points, target):
    """int [height, width]: 1 front, -1 back, and the polygon's trace."""
    polygon, footprint = new_polygon(), new_footprint(target)
    number = project(points, np.arange(3), target.frustum, polygon)
    image = np.zeros((HEIGHT, WIDTH), int)
    if number:
        extent = trace(polygon.corners, number, target, footprint)
        for y in range(extent.first, extent.end):
            image[y, footprint.growing[y] : footprint.shrinking[y]] = 1
            image[y, footprint.shrinking[y] : footprint.growing[y]] = -1
        return image, polygon, footprint, extent, number
    return image, polygon, footprint, None, 0


def test_pixels_whose_centres_are_inside_are_covered():
    image, *_ = coverage(seen_triangle([(1.5, 1.5), (1.5, 6.5), (6.5, 6.5)], [1, 1, 1]), flat_screen())
    rows = [(y, int(line.sum())) for y, line in enumerate(image) if line.any()]
    assert rows == [(3, 1), (4, 2), (5, 3), (6, 4)]
    assert image[3].nonzero()[0].tolist() == [2]
    assert image.max() == 1  # seen counterclockwise: y grows on the left


def test_a_triangle_the_other_way_round_is_a_back_face():
    image, *_ = coverage(seen_triangle([(1.5, 1.5), (6.5, 6.5), (1.5, 6.5)], [1, 1, 1]), flat_screen())
    assert (image.min(), image.max()) == (-1, 0)


def test_left_and_upper_edges_belong_to_a_triangle_right_and_lower_ones_do_not():
    image, *_ = coverage(seen_triangle([(2, 2), (2, 6), (6, 6)], [1, 1, 1]), flat_screen())
    assert image[2:7, 2:7].sum(axis=1).tolist() == [0, 1, 2, 3, 0]


points_near = st.tuples(*[st.integers(-8 * 16, 45 * 16)] * 2).map(lambda p: (p[0] / 16, p[1] / 16))


@settings(deadline=None)
@given(st.lists(points_near, min_size=4, max_size=4), st.lists(st.floats(0.01, 5), min_size=4, max_size=4))
def test_a_tetrahedron_covers_every_pixel_as_often_from_the_front_as_from_behind(corners, depths):
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    total = sum(
        coverage(seen_triangle([corners[i] for i in face], [depths[i] for i in face]), flat_screen())[0]
        for face in faces
    )
    assert not total.any()


@settings(deadline=None)
@given(
    st.lists(st.tuples(*[st.floats(-30, 30)] * 3), min_size=3, max_size=3),
    st.lists(st.sampled_from([0.0, 1.0]), min_size=3, max_size=3),
)
def test_clipping_keeps_what_a_ray_would_hit(places, weights):
    """A pixel is covered where the ray through it meets the unclipped triangle before its direction."""
    points = np.array([(*place, weight) for place, weight in zip(places, weights, strict=True)])
    determinant = np.linalg.det(points[:, :3])
    if abs(determinant) < 1.0:
        return
    image, *_ = coverage(points, flat_screen())
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)
    shares = rays @ np.linalg.inv(points[:, :3])
    reach = shares @ points[:, 3]  # closeness, times what the shares add up to
    inside = (shares > 1e-6).all(axis=1) & (reach < (1 - 1e-6) / 0.05)
    outside = (shares < -1e-6).any(axis=1) | (reach > (1 + 1e-6) / 0.05)
    assert image.reshape(-1)[inside].all()
    assert not image.reshape(-1)[outside].any()


@settings(deadline=None)
@given(
    st.lists(points_near, min_size=3, max_size=3),
    st.lists(st.floats(0.01, 5), min_size=3, max_size=3),
    st.sampled_from([4, 8, 16]),
)
def test_every_covered_pixel_is_in_a_tile_that_is_met(corners, depths, tile):
    target = flat_screen(10.0, tile)  # everything is behind
    image, polygon, footprint, extent, number = coverage(seen_triangle(corners, depths), target)
    if not number:
        return
    plane = plane_of(polygon.corners, number)
    tiles = footprint.tile[: meet_tiles(extent, plane, Z_FAIL, target, footprint)]
    met = np.zeros(target.rows * target.columns, bool)
    met[tiles] = True
    y, x = image.nonzero()
    assert met[(y // tile) * target.columns + x // tile].all()


@settings(deadline=None)
@given(
    st.lists(points_near, min_size=3, max_size=3),
    st.lists(st.floats(0.01, 5), min_size=3, max_size=3),
    points_near,
)
def test_closeness_stays_within_its_range(corners, depths, place):
    _, polygon, _, _, number = coverage(seen_triangle(corners, depths), flat_screen())
    if not number:
        return
    plane = plane_of(polygon.corners, number)
    low, high = closeness_range(plane, place[0], place[1], 4.0)
    values = [closeness(plane, place[0] + dx, place[1] + dy) for dx in (-4, 0, 4) for dy in (-4, 0, 4)]
    assert low <= min(values)
    assert max(values) <= high
    assert plane.low <= min(values)
    assert max(values) <= plane.high


def test_a_tile_is_cut_between_its_depths_and_counts_behind_them():
    depths = np.full((HEIGHT, WIDTH), 0.5, np.float32)
    depths[:8, :4] = 1.0  # tile 0 has depths 1 and 2
    target = screen(depths, 0.1, 8)
    everywhere = [(-100, -100), (-100, 200), (200, 50)]
    relations = {}
    for value in (0.25, 0.75, 2.0):
        _, polygon, footprint, extent, number = coverage(seen_triangle(everywhere, [value] * 3), target)
        plane = plane_of(polygon.corners, number)
        met = meet_tiles(extent, plane, Z_FAIL, target, footprint)
        relations[value] = dict(zip(footprint.tile[:met], footprint.relation[:met], strict=True))
    assert relations[0.25][0] != CUTS
    assert relations[0.25][1] != CUTS
    assert relations[0.75] == {0: CUTS}
    assert relations[2.0] == {}


def test_samples_stand_at_the_common_corners_of_blocks():
    target = flat_screen()
    around = [
        (6.5, 6.5),
        (6.5, 10.5),
        (10.5, 6.5),
    ]  # holds the corner of tiles at (7.5, 7.5), not that at (23.5, 7.5)
    _, _, footprint, extent, _ = coverage(seen_triangle(around, [1, 1, 1]), target)
    found = [(j, i) for j in range(2) for i in range(3) if covers_sample(extent, footprint, j, i)]
    assert found == [(0, 0)]


def test_a_polygon_behind_the_eye_is_dropped():
    frustum = Frustum(0.05, -100.0, 100.0, -100.0, 100.0)
    behind = np.array([(0, 0, -1.0, 1), (1, 0, -1, 1), (0, 1, -1, 1)])
    assert project(behind, np.arange(3), frustum, new_polygon()) == 0
