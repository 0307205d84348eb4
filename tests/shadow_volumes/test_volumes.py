"""Shadow volumes: closed, with as many triangles as they need, counted in front only where that is safe."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.scene.mesh import Mesh
from archsim.shadow_volumes.casters import Grouping, find_casters
from archsim.shadow_volumes.silhouette import net_edges
from archsim.shadow_volumes.volumes import Counting, Extrusion, num_drawn, seen_by, shadow_volumes
from tests.shadow.scenes import soup
from tests.shadow_volumes.scenes import BOX, BOX_TRIANGLES, floor_and, make_scene

Z_FAIL = Extrusion(Grouping.OBJECTS, Counting.Z_FAIL, None)


def box_scene(light, eye=(5.0, -4.0, 3.0), objects=None):
    return make_scene(BOX, BOX_TRIANGLES, eye, (0, 0, 0), light, objects=objects)


def volumes_of(scene, extrusion=Z_FAIL):
    return shadow_volumes(scene, scene.lights[0].position, extrusion)


def test_a_triangle_has_a_volume_of_eight_triangles():
    scene = make_scene([(0, 0, 1), (1, 0, 1), (0, 1, 1)], [(0, 1, 2)], (5, 0, 1), (0, 0, 0), (0, 0, 3))
    assert len(volumes_of(scene).triangles) == 1 + 1 + 3 * 2  # caps and three sides


def test_a_closed_box_starts_from_the_faces_that_the_light_sees():
    corner = volumes_of(box_scene((3.0, 3.0, 3.0)))  # sees three faces, six silhouette edges
    assert len(corner.triangles) == 6 + 6 + 6 * 2
    above = volumes_of(box_scene((0.5, 0.5, 3.0)))  # sees one face
    assert len(above.triangles) == 2 + 2 + 4 * 2


def test_a_light_inside_a_closed_box_is_shut_in_by_all_faces():
    inside = volumes_of(box_scene((0.5, 0.5, 0.5)))
    assert len(inside.triangles) == 12 + 12  # no silhouette at all


def test_an_open_box_starts_from_all_its_faces():
    scene = make_scene(BOX, BOX_TRIANGLES[:-2], (5, -4, 3), (0, 0, 0), (3, 3, 3))
    volumes = volumes_of(scene)
    assert len(net_edges(volumes.triangles.astype(np.int64), np.zeros(len(volumes.triangles), int))[0]) == 0
    assert len(volumes.triangles) > 20  # ten faces in each cap, and sides


def test_normals_point_out_of_the_volume():
    volumes = volumes_of(box_scene((0.5, 0.5, 3.0)))
    corners = volumes.points[volumes.triangles]
    finite = corners[(corners[..., 3] == 1).all(axis=1)][..., :3]
    normal = np.cross(finite[:, 1] - finite[:, 0], finite[:, 2] - finite[:, 0])
    assert (normal[:, 2] > 0).all()  # the light cap looks to the light


@settings(deadline=None)
@given(st.integers(0, 10_000), st.sampled_from(list(Grouping)), st.sampled_from(list(Counting)))
def test_every_volume_is_closed(seed, grouping, counting):
    volumes = volumes_of(soup(seed), Extrusion(grouping, counting, 20.0))
    number = np.repeat(np.arange(len(volumes.z_pass)), np.diff(volumes.starts))
    a, b, _ = net_edges(volumes.triangles.astype(np.int64), number)
    assert len(a) == len(b) == 0


def test_z_pass_is_left_where_a_volume_may_reach_the_near_plane():
    adaptive = Extrusion(Grouping.OBJECTS, Counting.ADAPTIVE, None)
    assert volumes_of(box_scene((0.5, 0.5, 9.0)), adaptive).z_pass.tolist() == [True]
    behind_the_box = box_scene((-9.0, 0.5, 0.5), eye=(9.0, 0.5, 0.5))  # looking towards the light
    assert volumes_of(behind_the_box, adaptive).z_pass.tolist() == [False]


def test_z_pass_needs_no_dark_cap_at_infinity():
    scene = box_scene((0.5, 0.5, 9.0))
    without = volumes_of(scene, Z_FAIL._replace(counting=Counting.ADAPTIVE))
    assert len(volumes_of(scene).triangles) - len(without.triangles) == 2


def test_z_pass_draws_no_light_cap():
    scene = box_scene((0.5, 0.5, 9.0))  # above: the cap is the box's top
    z_pass, z_fail = volumes_of(scene, Z_FAIL._replace(counting=Counting.ADAPTIVE)), volumes_of(scene)
    assert (z_pass.drawn - z_pass.starts[:-1]).tolist() == [2]
    assert num_drawn(z_pass) == 8  # two triangles for each edge of the top
    assert (z_fail.drawn - z_fail.starts[:-1]).tolist() == [0]
    assert num_drawn(z_fail) == 12  # and both caps


def test_volumes_end_at_the_range():
    volumes = volumes_of(box_scene((0.5, 0.5, 3.0)), Z_FAIL._replace(range=10.0))
    dark = volumes.points[len(volumes.points) // 2 :]
    np.testing.assert_allclose(np.linalg.norm(dark[:, :3] - (0.5, 0.5, 3.0), axis=1), 10.0)
    assert (dark[:, 3] == 1).all()


def test_points_at_infinity_are_seen_where_points_far_away_are():
    scene = box_scene((0.5, 0.5, 9.0))
    direction = np.array([[-3.0, 2.5, -2.0, 0.0], [-3e9, 2.5e9, -2e9, 1.0]])
    seen = seen_by(direction, scene.camera, scene.width, scene.height)
    np.testing.assert_allclose(seen[0, :2] / seen[0, 2], seen[1, :2] / seen[1, 2], rtol=1e-6)


@pytest.mark.parametrize(
    ("grouping", "expected"),
    [
        (Grouping.OBJECTS, [0, 0, 1]),
        (Grouping.PARTS, [0, 1, 2]),
        (Grouping.WHOLE, [0, 0, 0]),
        (Grouping.TRIANGLES, [0, 1, 2]),
    ],
)
def test_triangles_are_grouped(grouping, expected):
    vertices = np.random.default_rng(0).normal(size=(12, 3)).astype(np.float32)
    triangles = np.arange(12, dtype=np.int32).reshape(4, 3)
    mesh = Mesh(vertices, triangles, np.array([7, 7, -1, 2], np.int32))
    casters = find_casters(mesh, grouping)
    assert casters.caster.tolist() == expected
    assert casters.num_casters == max(expected) + 1


def test_parts_meet_at_equal_places_and_degenerate_triangles_do_not_count():
    vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.0, 0.0, 0.0), (-1, 0, 0), (0, -1, 0), (5, 5, 5)]
    triangles = [(0, 1, 2), (3, 4, 5), (6, 6, 6)]
    casters = find_casters(Mesh(np.array(vertices, np.float32), np.array(triangles, np.int32)))
    assert (casters.caster.tolist(), len(casters.positions)) == ([0, 0], 6)


def test_receivers_cast_no_shadow():
    vertices, triangles, objects = floor_and([(0, 0, 1), (1, 0, 1), (0, 1, 1)], [(0, 1, 2)])
    scene = make_scene(vertices, triangles, (3, -3, 3), (0, 0, 0), (0, 0, 5), objects=objects)
    assert len(volumes_of(scene).triangles) == 8
