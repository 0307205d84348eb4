"""Cones and cubes around lights, and corners of what planes enclose."""

import math

import numpy as np
import pytest

from archsim.shadowmap.cone import NEAREST, cone_axis, hull, pieces

from .views import OVERHEAD, view_of


def test_the_corners_of_a_cube():
    planes = np.array([[*(sign * axis), 1.0] for axis in np.eye(3) for sign in (1, -1)])
    found = {tuple(point) for point in hull(planes).round(9)}

    assert found == {(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)}
    assert len(hull(np.concatenate([planes, [[1.0, 0, 0, -2]]]))) == 0


def test_the_narrowest_cone_of_three_directions_by_hand():
    """Three directions 30 degrees around z, and one inside."""
    turns = np.radians([0, 120, 240])
    around = np.stack([0.5 * np.cos(turns), 0.5 * np.sin(turns), np.full(3, math.sqrt(0.75))], axis=1)

    assert cone_axis(np.concatenate([around, [[0.1, 0, 1.0]]])) == pytest.approx(np.array([0, 0, 1.0]))


def test_directions_all_around_have_no_cone():
    assert cone_axis(np.concatenate([np.eye(3), -np.eye(3)])) is None
    assert cone_axis(np.array([[1.0, 0, 0], [-1.0, 0.1, 0]])) is None


def test_a_sun_sees_all_in_one_piece():
    (piece,) = pieces(view_of(20), OVERHEAD, 1, 20)

    assert piece.axis == pytest.approx(np.array([0, 0, -1.0]))
    assert len(piece.points) == 8


def test_the_faces_of_a_cube_share_what_is_farther_than_the_nearest():
    """The volumes of the pieces and the small cube around the light add up to the view's."""
    light = np.array([0.2, 5.0, 0.5, 1.0])
    rays = np.random.default_rng(0).normal(size=(200, 3))
    found = pieces(view_of(20), light, 1, 20)
    owners = [
        (np.concatenate([rays, np.zeros((200, 1))], axis=1) @ (p.region * [1, 1, 1, 0]).T >= 0) for p in found
    ]

    assert len(found) == 6
    assert (np.stack([inside.all(axis=1) for inside in owners]).sum(axis=0) == 1).all()
    for piece in found:
        heights = (piece.points - light[:3]) @ piece.axis
        assert heights.min() > 0.9 * NEAREST * heights.max()
