"""Cones and cubes around lights, and corners of what planes enclose."""

import math

import numpy as np
import pytest

from archsim.shadowmap.cone import NEAREST, clip, cone_axis, pieces, volume
from archsim.shadowmap.view import at_depth, point_light

from .views import OVERHEAD, view_of

SQUARE = np.array([[1.0, 1, 1], [-1, 1, 1], [-1, -1, 1], [1, -1, 1]])


def test_a_square_is_clipped_to_a_half_a_quarter_and_nothing():
    right, above = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])

    assert {tuple(p) for p in clip(SQUARE, right[None])} == {(1, 1, 1), (0, 1, 1), (0, -1, 1), (1, -1, 1)}
    quarter = clip(SQUARE, np.array([right, above]))
    assert {tuple(p) for p in quarter} == {(1, 1, 1), (0, 1, 1), (0, 0, 1), (1, 0, 1)}
    assert clip(SQUARE, np.array([[0, 0, -1.0]])).shape == (0, 3)


def test_a_polygon_around_the_light_itself_is_clipped_to_its_own_corner():
    flat = SQUARE * [1, 1, 0]

    assert {tuple(p) for p in clip(flat, np.array([[1.0, 1, 0], [1, -1, 0]]))} == {
        (1, 1, 0),
        (1, -1, 0),
        (0, 0, 0),
    }


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
    assert len(piece.outline) == len(volume(piece, OVERHEAD)) == 8


def test_a_light_inside_the_view_sees_all_through_the_faces_of_a_cube():
    """Every light ray is of one face, and what a face holds starts at the nearest depth."""
    light = np.array([0.2, 5.0, 0.5, 1.0])
    rays = np.random.default_rng(0).normal(size=(200, 3))
    found = pieces(view_of(20), light, 1, 20)
    owners = [
        (np.concatenate([rays, np.zeros((200, 1))], axis=1) @ (p.region * [1, 1, 1, 0]).T >= 0) for p in found
    ]

    assert len(found) == 6
    assert (np.stack([inside.all(axis=1) for inside in owners]).sum(axis=0) == 1).all()
    for piece in found:
        heights = (volume(piece, light) - light[:3]) @ piece.axis
        assert heights.min() == pytest.approx(NEAREST * heights.max())


def test_a_light_right_outside_a_corner_sees_one_piece_from_the_nearest_depth_on():
    """A light all but on a corner would leave no depth to all the rest of the view."""
    view = view_of(20)
    corner = at_depth(view, np.array(1.0), np.array(1.0), np.array(20.0))
    middle = at_depth(view, np.array(0.0), np.array(0.0), np.array(10.0))
    light = point_light(corner + 1e-6 * (corner - middle))
    (piece,) = pieces(view, light, 1, 20)
    heights = (volume(piece, light) - light[:3]) @ piece.axis

    assert heights.min() == pytest.approx(NEAREST * heights.max())


def test_a_light_on_a_face_of_the_view_sees_nothing_behind_it():
    found = pieces(view_of(20), point_light([0, 1, 0]), 1, 20)

    assert [piece.name for piece in found] == ["right", "left", "up", "down", "ahead"]
