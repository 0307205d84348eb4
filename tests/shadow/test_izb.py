"""The plain irregular z-buffer: equal to brute force, near to the ray tracer, sane at the edges."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.raster.eye_view import eye_view
from archsim.scene.mesh import Mesh
from archsim.scene.scene import Light
from archsim.shadow import izb, ray_trace
from archsim.shadow.grid import Grid
from archsim.shadow.plain import Method, plan_faces, run_face, shadow_mask
from tests.shadow.scenes import facing_quad, soup

METHOD = Method(Grid(64, 48, 32, 16, 4, 4), (4, 4), 1 / 64)


def view_of(scene):
    return eye_view(scene.mesh, scene.camera, scene.width, scene.height)


def mask_of(scene, method=METHOD):
    return shadow_mask(scene, view_of(scene), scene.lights[0], method)[0]


def below(scene, *triangles):
    """The scene with further triangles."""
    vertices = np.array(triangles, np.float32).reshape(-1, 3)
    new = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3) + len(scene.mesh.vertices)
    return scene._replace(
        mesh=Mesh(
            np.concatenate([scene.mesh.vertices, vertices]), np.concatenate([scene.mesh.triangles, new])
        )
    )


@given(st.integers(0, 10**6))
@settings(max_examples=60, deadline=None)
def test_equal_to_brute_force(seed):
    """No sample is lost by the grid: triangles through the light plane, behind it, edge-on and off screen included."""
    scene = soup(seed)
    for plan in plan_faces(scene, view_of(scene), scene.lights[0], METHOD):
        outcome = run_face(plan, METHOD.grid)
        found = izb.in_shadow(outcome.z_test, outcome.samples)
        np.testing.assert_array_equal(found, izb.in_shadow_brute_force(outcome.samples, plan.occluders))


@given(st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_the_mask_does_not_depend_on_the_grid(seed):
    """Other grid sizes move the light-space coordinates, so only samples on a shadow's edge may change."""
    scene = soup(seed, size=(48, 32))
    coarse = Method(Grid(16, 16, 4, 4, 2, 2), (8, 2), 1 / 256)
    assert (mask_of(scene) != mask_of(scene, coarse)).mean() < 0.01


@pytest.mark.parametrize("seed", range(8))
def test_near_to_the_ray_tracer(seed):
    scene = soup(seed, num_triangles=40, size=(96, 64))
    assert (mask_of(scene) != ray_trace.shadow_mask(scene, 0)).mean() < 0.005


def test_list_order_is_last_in_first_out_and_complete():
    scene = soup(3)
    (plan, *_) = plan_faces(scene, view_of(scene), scene.lights[0], METHOD)
    lists = run_face(plan, METHOD.grid).lists
    listed = []
    for head in lists.head:
        chain = []
        while head != izb.NO_NODE:
            chain.append(head)
            head = lists.following[head]
        assert chain == sorted(chain, reverse=True)
        listed += chain
    assert len(listed) == len(set(listed)) == plan.face.taken.sum()


def test_an_occluder_shadows_what_is_behind_it_only():
    scene = below(facing_quad((0, 0, 1.5)), [(-0.1, -0.1, 1), (0.1, -0.1, 1), (0, 0.1, 1)])
    mask = mask_of(scene)
    triangle = view_of(scene).triangle
    assert mask.any()
    assert not mask[triangle == 2].any()
    assert not mask[triangle < 0].any()
    behind_light = below(facing_quad((0, 0, 1.5)), [(-0.1, -0.1, 1.8), (0.1, -0.1, 1.8), (0, 0.1, 1.8)])
    visible = view_of(behind_light).triangle
    np.testing.assert_array_equal(mask_of(behind_light), visible == 2)


def test_a_surface_lit_from_its_far_side_is_in_shadow():
    scene = facing_quad((0.1, 0.2, -1.0))
    seen = view_of(scene)
    np.testing.assert_array_equal(mask_of(scene), seen.triangle >= 0)


def test_the_own_surface_casts_no_shadow_even_at_grazing_angles():
    for height in (2.0, 0.3, 0.05, 0.01):
        assert not mask_of(facing_quad((0.9, 0.2, height), size=(64, 64))).any()


def test_degenerate_triangles_cast_nothing():
    scene = below(facing_quad((0, 0, 1.5)), [(0, 0, 1)] * 3, [(-1, 0, 1), (0, 0, 1), (1, 0, 1)])
    assert not mask_of(scene).any()


def test_no_triangles_no_shadow():
    scene = facing_quad((0, 0, 1))
    assert not mask_of(scene._replace(mesh=Mesh(scene.mesh.vertices, np.empty((0, 3), np.int32)))).any()


def test_a_light_on_a_vertex_or_at_the_eye_is_harmless():
    scene = facing_quad((0, 0, 2))
    assert not mask_of(scene).any()
    on_vertex = scene._replace(lights=(Light(np.array([1.0, 1.0, 0.0]), None),))
    assert mask_of(on_vertex).shape == (scene.height, scene.width)


def test_the_z_test_counts_each_replacement():
    samples = izb.Samples(np.array([[0, 0, 0.5], [0, 0, 0.25]], np.float32), np.zeros((2, 2), np.int32))
    first = np.array([0, 0, 1, 0], np.int32), np.array([0.25, 0.4, 0.3, 0.0], np.float32)
    state = izb.z_test_fragments(izb.z_test(samples), *first)
    assert state.num_passed == 2
    np.testing.assert_array_equal(state.nearest, np.array([0.0, 0.25], np.float32))
    np.testing.assert_array_equal(izb.in_shadow(state, samples), [True, False])


@pytest.mark.parametrize("distance", [3.0, 1e2, 1e3, 1e4, 1e5, 1e6])
def test_a_shadow_does_not_depend_on_how_far_away_the_light_is(distance):
    """Beyond some distance the rays are parallel: 1e6 times the scene's size still gives the picture of 1e3."""
    occluder = [(-0.2, -0.2, 0.5), (0.2, -0.2, 0.5), (0, 0.3, 0.5)]
    direction = np.array([0.2, -0.13, 1.0])
    masks = [mask_of(below(facing_quad(direction * d, size=(64, 64)), occluder)) for d in (1e3, distance)]
    assert masks[0].any()
    allowed = 0.03 if distance < 1e3 else 0.002
    assert (masks[0] != masks[1]).mean() <= allowed
