"""Generated meshes: counts, closedness, determinism, and parameters that make no sense."""

import numpy as np
import pytest

from archsim.errors import ArchsimError
from archsim.scene.generators import GENERATORS, make_mesh
from archsim.scene.generators.power_plant import HEADROOM
from archsim.scene.generators.registry import MAX_TRIANGLES

SMALL = {"tube_segments": 30, "tube_sides": 5, "sphere_slices": 6, "sphere_stacks": 4, "num_spheres": 3}


def is_closed(triangles):
    """Whether every edge is used exactly once each way."""
    edges = [(int(t[i]), int(t[(i + 1) % 3])) for t in triangles for i in range(3)]
    used = set(edges)
    return len(used) == len(edges) and all((b, a) in used for a, b in edges)


def test_quad_and_triangle_is_what_it_says():
    mesh = make_mesh("quad_and_triangle", 0, {})
    corners = mesh.vertices[mesh.triangles]
    assert corners.shape == (3, 3, 3)
    assert (corners[:2, :, 2] == 0).all()
    assert (corners[2, :, 2] == 0.5).all()
    assert set(map(tuple, corners[:2, :, :2].reshape(-1, 2))) == {(-1, -1), (1, -1), (1, 1), (-1, 1)}


def test_knot_has_the_papers_number_of_triangles():
    mesh = make_mesh("knot_and_spheres", 3, {})
    assert mesh.triangles.shape == (16_372, 3)
    assert (mesh.vertices.dtype, mesh.triangles.dtype) == (np.float32, np.int32)


def test_knot_parts_are_closed_and_inside_the_room():
    mesh = make_mesh("knot_and_spheres", 3, SMALL)
    edges_are_closed = is_closed(mesh.triangles)
    assert edges_are_closed
    room = mesh.vertices[-8:]
    assert (np.abs(mesh.vertices[:-8]) < np.abs(room).max()).all()
    assert (np.abs(room) == 6).all()


def test_knot_tube_keeps_its_radius():
    sides = SMALL["tube_sides"]
    mesh = make_mesh("knot_and_spheres", 3, SMALL)
    rings = mesh.vertices[: 30 * sides].reshape(30, sides, 3)
    radii = np.linalg.norm(rings - rings.mean(axis=1, keepdims=True), axis=-1)
    np.testing.assert_allclose(radii, 0.35, rtol=1e-5)


def test_spheres_are_round_and_do_not_meet():
    mesh = make_mesh("knot_and_spheres", 5, SMALL)
    each = 6 * 3 + 2
    spheres = mesh.vertices[30 * 5 : -8].reshape(3, each, 3).astype(np.float64)
    centres = spheres[:, -2:].mean(axis=1)
    radii = np.linalg.norm(spheres - centres[:, None], axis=-1)
    np.testing.assert_allclose(radii, np.broadcast_to(radii[:, :1], radii.shape), rtol=1e-5)
    assert ((radii[:, 0] >= 0.4) & (radii[:, 0] <= 0.8)).all()
    for one in range(3):
        for other in range(one):
            assert np.linalg.norm(centres[one] - centres[other]) > radii[one, 0] + radii[other, 0]


@pytest.mark.parametrize("name", sorted(GENERATORS))
def test_the_same_seed_gives_the_same_bytes_and_the_count_announced(name):
    one, other = make_mesh(name, 11, {}), make_mesh(name, 11, {})
    assert one.vertices.tobytes() == other.vertices.tobytes()
    assert one.triangles.tobytes() == other.triangles.tobytes()
    assert len(one.triangles) == GENERATORS[name].num_triangles(GENERATORS[name].defaults)


def test_another_seed_moves_the_spheres_only():
    one, other = make_mesh("knot_and_spheres", 1, SMALL), make_mesh("knot_and_spheres", 2, SMALL)
    moved = (one.vertices != other.vertices).any(axis=1)
    assert moved[150:-8].all()
    assert not moved[:150].any()
    assert not moved[-8:].any()


@pytest.mark.parametrize("name", sorted(GENERATORS))
def test_the_lowest_parameters_still_make_a_mesh(name):
    lowest = GENERATORS[name].lowest
    mesh = make_mesh(name, 0, lowest._asdict())
    assert np.isfinite(mesh.vertices).all()
    assert len(mesh.triangles) == GENERATORS[name].num_triangles(lowest)
    assert mesh.triangles.max() < len(mesh.vertices)


@pytest.mark.parametrize(
    ("generator", "seed", "parameters", "said"),
    [
        ("knot_and_sphere", 0, {}, "did you mean 'knot_and_spheres'?"),
        ("teapot", 0, {}, "known are amphitheater, knights, knot_and_spheres, power_plant"),
        ("quad_and_triangle", -1, {}, "seed must not be negative"),
        ("quad_and_triangle", 0, {"hieght": 1}, "did you mean 'height'?"),
        ("quad_and_triangle", 0, {"zzz": 1}, "known are height"),
        ("quad_and_triangle", 0, {"height": float("nan")}, "height must be a finite number"),
        ("quad_and_triangle", 0, {"height": True}, "height must be a finite number"),
        ("knot_and_spheres", 0, {"tube_sides": 3.5}, "tube_sides must be a whole number, not 3.5"),
        ("knot_and_spheres", 0, {"tube_sides": 2}, "tube_sides must be at least 3, not 2"),
        ("knot_and_spheres", 0, {"tube_sides": 10**6}, f"at most {MAX_TRIANGLES} are made"),
    ],
)
def test_wrong_requests_are_named(generator, seed, parameters, said):
    with pytest.raises(ArchsimError) as caught:
        make_mesh(generator, seed, parameters)
    assert said in str(caught.value)


def test_all_wrong_parameters_are_told_together():
    with pytest.raises(ArchsimError) as caught:
        make_mesh("knot_and_spheres", 0, {"tube_sides": 1, "tube_segment": 4})
    assert len(caught.value.problems) == 2


@pytest.mark.parametrize("name", ["simple_occluder", "knights", "amphitheater", "power_plant"])
def test_shadow_casting_objects_of_generated_meshes_are_closed_parts(name):
    small = {"power_plant": {"bays": 1, "floors": 1, "pipes": 3, "tanks": 1, "chimneys": 1}}
    mesh = make_mesh(name, 1, small.get(name, {}))
    assert mesh.objects.shape == (len(mesh.triangles),)
    assert mesh.objects.min() == -1  # what only receives
    for index in range(mesh.objects.max() + 1):
        own = mesh.triangles[mesh.objects == index]
        assert len(own) == 1 or is_closed(own)


def test_pipes_leave_walkways_free():
    size = {"bays": 3, "floors": 2, "pipes": 150, "runs": 4, "tanks": 0, "chimneys": 0}
    walked, crowded = (make_mesh("power_plant", 2, {**size, **more}) for more in ({"walkway": 2.0}, {}))
    assert len(walked.triangles) == len(crowded.triangles)

    def in_walkways(mesh):
        """Points of pipes, a tenth of the way between their rings apart."""
        pipes = mesh.vertices[-150 * (11 * 12 + 2) :].reshape(150, -1, 3)
        rings = pipes[:, :-2].reshape(150, 11, 12, 3)
        share = np.linspace(0, 1, 11)[:, None, None, None, None]
        points = ((1 - share) * rings[:, :-1] + share * rings[:, 1:]).reshape(-1, 3)
        return ((np.abs(points[:, 0]) < 1.0) & (points[:, 2] % 6.0 < HEADROOM)).sum()

    assert in_walkways(walked) == 0
    assert in_walkways(crowded) > 0


def test_walkways_as_wide_as_the_plant_leave_no_room():
    low = {"bays": 1, "floors": 1, "bay_size": 2.0, "pipes": 1, "walkway": 4.0}
    with pytest.raises(ArchsimError, match="walkways 4 wide leave pipes no room in bays of 2"):
        make_mesh("power_plant", 0, low)


def test_solids_of_a_power_plant_are_dealt_to_objects_place_by_place():
    small = {"bays": 2, "floors": 1, "pipes": 6, "tanks": 2, "chimneys": 0}
    whole, cut = (make_mesh("power_plant", 1, {**small, **more}) for more in ({}, {"places": 3, "kinds": 2}))
    assert set(whole.objects) == {-1, 0}
    assert set(cut.objects) == {-1, 0, 1, 2, 3, 4, 5}
    assert (cut.vertices == whole.vertices).all()
    middles = [cut.vertices[cut.triangles[cut.objects // 2 == place]][..., 0].mean() for place in range(3)]
    assert middles == sorted(middles)


def test_the_amphitheaters_columns_are_one_object_and_each_actor_is_one():
    mesh = make_mesh("amphitheater", 1, {"actors": 3, "columns": 4, "column_sides": 5})
    assert np.bincount(mesh.objects[mesh.objects >= 0]).tolist() == [4 * 20, 562, 532, 562]


def test_the_simple_scene_is_the_inside_of_a_room():
    mesh = make_mesh("simple_occluder", 0, {})
    assert np.abs(mesh.vertices).max() == 100
    walls = mesh.vertices[mesh.triangles[:10]]
    normals = np.cross(walls[:, 1] - walls[:, 0], walls[:, 2] - walls[:, 0])
    assert (np.einsum("nk,nk->n", normals, walls[:, 0]) < 0).all()  # they look inwards
    assert (mesh.objects >= 0).sum() == 1


def test_animated_characters_repeat_after_nine_frames():
    poses = [make_mesh("knights", 0, {"knights": 2, "pose": pose}).vertices for pose in (0.5, 5.0, 9.5)]
    np.testing.assert_allclose(poses[0], poses[2], atol=1e-6)
    assert np.abs(poses[0] - poses[1]).max() > 0.1
