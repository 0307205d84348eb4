"""Rays and axes, against cameras simple enough to work out by hand."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from archsim.errors import ArchsimError
from archsim.scene.camera import Camera, camera_axes, pixel_rays, to_view_space, view_window


def camera(eye=(0, 0, 0), target=(0, 1, 0), up=(0, 0, 1), fovy=90.0, near=0.1):
    return Camera(*(np.array(point, dtype=np.float64) for point in (eye, target, up)), fovy, near)


def test_axes_of_a_camera_that_looks_north_with_z_up():
    np.testing.assert_allclose(camera_axes(camera()), [(1, 0, 0), (0, 0, 1), (0, 1, 0)], atol=1e-15)


def test_up_need_not_be_perpendicular_nor_of_length_one():
    np.testing.assert_allclose(camera_axes(camera(up=(0, 30, 7))), camera_axes(camera()), atol=1e-15)


def test_row_0_is_the_top_and_column_0_the_left():
    rays = pixel_rays(camera(eye=(5, 6, 7), target=(5, 7, 7)), 4, 2)
    np.testing.assert_allclose(rays.origin, (5, 6, 7))
    np.testing.assert_allclose(rays.corner, (-1.5, 1, 0.5))
    np.testing.assert_allclose(rays.step_x, (1, 0, 0), atol=1e-15)
    np.testing.assert_allclose(rays.step_y, (0, 0, -1), atol=1e-15)


def test_one_pixel_looks_straight_ahead():
    np.testing.assert_allclose(pixel_rays(camera(), 1, 1).corner, (0, 1, 0), atol=1e-15)


coordinate = st.floats(-100, 100)
point = st.tuples(coordinate, coordinate, coordinate)


@given(eye=point, offset=point, up=point, pixel=st.tuples(st.integers(0, 39), st.integers(0, 29)))
def test_rays_advance_by_one_and_agree_with_the_window(eye, offset, up, pixel):
    across = np.linalg.norm(np.cross(offset, up))
    assume(np.linalg.norm(offset) > 1e-3 and across > 1e-3 * np.linalg.norm(offset) * np.linalg.norm(up))
    view = camera(eye, np.add(eye, offset), up, 50.0)
    x, y = pixel
    rays, window = pixel_rays(view, 40, 30), view_window(view, 40, 30)
    direction = rays.corner + x * rays.step_x + y * rays.step_y
    expected = (window.left + x * window.step_x, window.top + y * window.step_y, 1)
    np.testing.assert_allclose(camera_axes(view) @ direction, expected, atol=1e-12)
    seen = to_view_space(rays.origin + 3 * direction[None], view)[0]
    np.testing.assert_allclose(seen, 3 * np.array(expected), atol=1e-10)


def test_equal_points_stay_equal_wherever_they_stand():
    view = camera((1, 2, 3), (9, -4, 2.5))
    points = np.tile(np.float32([(0.1, 0.7, -0.3)]), (1001, 1))
    moved = to_view_space(points, view)
    assert (moved == moved[0]).all()


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_lengths_of_directions_do_not_matter(scale):
    view = camera(target=(0, scale, 0), up=(0, 0, scale))
    np.testing.assert_allclose(camera_axes(view), camera_axes(camera()), atol=1e-15)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"target": (0, 0, 0)}, "same point"),
        ({"up": (0, 0, 0)}, "up is zero"),
        ({"up": (0, -3, 0)}, "along the line of sight"),
        ({"target": (0, np.nan, 0)}, "camera"),
    ],
)
def test_cameras_without_axes_are_refused(wrong, said):
    with pytest.raises(ArchsimError, match=said):
        camera_axes(camera(**wrong))


@pytest.mark.parametrize("wrong", [{"near": 0.0}, {"near": -1.0}, {"fovy": 0.0}, {"fovy": 180.0}])
def test_windows_need_a_near_plane_and_an_angle(wrong):
    with pytest.raises(ArchsimError, match="near must be"):
        view_window(camera(**wrong), 4, 4)
