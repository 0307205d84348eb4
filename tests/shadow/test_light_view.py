"""Every sample goes to exactly one view, and lands inside that view's grid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.raster.eye_view import eye_view
from archsim.scene.scene import LightView
from archsim.shadow.grid import Grid
from archsim.shadow.izb import place_samples
from archsim.shadow.light_view import light_faces, sample_points
from archsim.shadow.pixel_tiles import cut
from archsim.shadow.transform import light_transform
from tests.shadow.scenes import facing_quad, soup

GRID = Grid(64, 32, 16, 16, 4, 4)


def view_of(scene):
    return eye_view(scene.mesh, scene.camera, scene.width, scene.height)


@given(st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_each_sample_is_taken_once_and_lies_in_the_grid(seed):
    scene = soup(seed)
    seen = view_of(scene)
    faces = light_faces(scene, seen, scene.lights[0], GRID)
    taken = sum((face.taken.astype(int) for face in faces), np.zeros((scene.height, scene.width), int))
    assert len(faces) <= 6
    np.testing.assert_array_equal(taken, seen.triangle >= 0)
    for face in faces:
        samples = place_samples(
            cut(seen.reciprocal_depth, face.taken, (4, 4)), light_transform(scene, face, (4, 4))
        )
        cell = samples.cell[~np.isnan(samples.position[:, 0])]
        assert len(cell) == face.taken.sum()
        assert (cell >= 0).all()
        assert (cell < (GRID.logical_width, GRID.logical_height)).all()


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_the_float32_chain_is_near_the_float64_projection(seed):
    scene = soup(seed)
    seen = view_of(scene)
    points = sample_points(scene, seen)
    for face in light_faces(scene, seen, scene.lights[0], GRID):
        tiles = cut(seen.reciprocal_depth, face.taken, (4, 4))
        samples = place_samples(tiles, light_transform(scene, face, (4, 4)))
        homogeneous = (points - face.light) @ face.to_logical.T
        placed = np.flatnonzero(~np.isnan(samples.position[:, 0]))
        expected = homogeneous.reshape(-1, 3)[tiles.pixel[placed]]
        np.testing.assert_allclose(samples.position[placed, 0], expected[:, 0] / expected[:, 2], atol=0.02)
        np.testing.assert_allclose(samples.position[placed, 1], expected[:, 1] / expected[:, 2], atol=0.02)
        depth = 1 - face.nearest / expected[:, 2]
        np.testing.assert_allclose(samples.position[placed, 2], depth, atol=1e-3)
        assert depth.min() >= 0


def test_a_distant_light_needs_one_tight_view():
    scene = facing_quad((0.3, 0.2, 5))
    seen = view_of(scene)
    (face,) = light_faces(scene, seen, scene.lights[0], GRID)
    samples = place_samples(
        cut(seen.reciprocal_depth, face.taken, (8, 8)), light_transform(scene, face, (8, 8))
    )
    cell = samples.cell[samples.cell[:, 0] >= 0]
    np.testing.assert_array_equal(cell.min(axis=0), (0, 0))
    np.testing.assert_array_equal(cell.max(axis=0), (GRID.logical_width - 1, GRID.logical_height - 1))


def test_a_near_light_needs_several_views():
    scene = facing_quad((0.05, 0.02, 0.1))
    assert len(light_faces(scene, view_of(scene), scene.lights[0], GRID)) == 5


@pytest.mark.parametrize(("fovy", "num_faces"), [(60.0, 1), (5.0, 6)])
def test_a_given_view_is_used_if_it_holds_all_samples(fovy, num_faces):
    view = LightView(np.array([0.3, 0.2, 0.0]), np.array([0.0, 1, 0]), fovy)
    scene = facing_quad((0.3, 0.2, 5), view)
    faces = light_faces(scene, view_of(scene), scene.lights[0], GRID)
    assert len(faces) <= num_faces
    if num_faces == 1:
        extent = np.tan(np.radians(30)) * 5
        corner = faces[0].to_logical @ np.array([-extent, extent, -5.0])
        np.testing.assert_allclose(np.abs(corner[:2] / corner[2] - (32, 16)), (32, 16), atol=0.06)


def test_pixels_that_show_nothing_have_no_view():
    scene = facing_quad((0, 0, 5))
    nothing = scene._replace(mesh=scene.mesh._replace(triangles=np.empty((0, 3), np.int32)))
    assert light_faces(nothing, view_of(nothing), nothing.lights[0], GRID) == []


def test_samples_at_the_light_itself_are_left_out():
    scene = facing_quad((0, 0, 0), size=(33, 33))
    seen = view_of(scene)
    assert not any(face.taken[16, 16] for face in light_faces(scene, seen, scene.lights[0], GRID))
