"""The ray tracer against shadows worked out by hand, every triangle tried, and the rasterizer's own visibility."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.raster.eye_view import eye_view
from archsim.scene.camera import Camera, pixel_rays
from archsim.scene.generators import make_mesh
from archsim.scene.mesh import Mesh, load_mesh
from archsim.scene.scene import Light, Scene
from archsim.shadow.box_tree import INNER, build_tree
from archsim.shadow.ray_trace import clearance, primary_hits, shadow_mask


def point(*coordinates):
    return np.array(coordinates, dtype=np.float64)


# Looks straight down at the floor from z = 3, with x to the right and y up in the image.
DOWN = Camera(point(0, 0, 3), point(0, 0, 0), point(0, 1, 0), 40.0, 0.01)


def scene(mesh, *lights, camera=DOWN, size=(40, 32)):
    return Scene(mesh, camera, tuple(Light(point(*at), None) for at in lights), *size, "test")


def soup(corners):
    corners = np.asarray(corners, dtype=np.float32).reshape(-1, 3)
    return Mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))


def random_soup(seed, number, size=0.8):
    """Triangles of mixed sizes in the cube -1 .. 1."""
    random = np.random.default_rng(seed)
    middles = random.uniform(-1, 1, (number, 1, 3))
    return soup(
        middles + random.uniform(-1, 1, (number, 3, 3)) * size * random.uniform(0.2, 1, (number, 1, 1))
    )


def seen_points(view):
    """Where the pixels' rays meet the floor z = 0, [height, width, 3]."""
    rays = pixel_rays(view.camera, view.width, view.height)
    x, y = np.arange(view.width)[None, :, None], np.arange(view.height)[:, None, None]
    direction = rays.corner + x * rays.step_x + y * rays.step_y
    return rays.origin - direction * rays.origin[2] / direction[..., 2:]


def test_the_shadow_of_a_triangle_on_the_floor():
    """The occluder at z = 0.5, seen from a light at (0.2, -0.1, 2), is enlarged 4/3 times away from the light."""
    view = scene(make_mesh("quad_and_triangle", 0, {}), (0.2, -0.1, 2))
    light, position = point(0.2, -0.1), seen_points(view)[..., :2]
    occluder = np.array([(-0.4, -0.3), (0.4, -0.3), (0.0, 0.4)])
    corners = light + (occluder - light) * 4 / 3
    sides = [
        np.cross(np.append(b - a, 0), np.concatenate([position - a, 0 * position[..., :1]], axis=-1))[..., 2]
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
    ]
    triangle = primary_hits(view).triangle
    expected = (np.min(sides, axis=0) > 0) & (triangle != 2) & (triangle >= 0)
    assert 20 < expected.sum() < 200
    np.testing.assert_array_equal(shadow_mask(view, 0), expected)


def test_the_background_is_not_in_shadow():
    view = scene(make_mesh("quad_and_triangle", 0, {}), (0, 0, -2))
    triangle = primary_hits(view).triangle
    assert (triangle < 0).any()
    np.testing.assert_array_equal(shadow_mask(view, 0), triangle >= 0)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("light_height", "dark"), [(1.0, False), (-1.0, True)])
def test_a_light_behind_the_visible_side_leaves_it_dark(turned, light_height, dark):
    corners = [(-9, -9, 0), (9, -9, 0), (0, 9, 0)]
    mask = shadow_mask(scene(soup(corners[::-1] if turned else corners), (0.1, 0.2, light_height)), 0)
    assert (mask == dark).all()


def test_what_lies_beyond_the_light_casts_no_shadow():
    floor, lid = [(-9, -9, 0), (9, -9, 0), (0, 9, 0)], [(-9, -9, 5), (9, -9, 5), (0, 9, 5)]
    assert not shadow_mask(scene(soup([floor, lid]), (0, 0, 4.9)), 0).any()
    assert shadow_mask(scene(soup([floor, lid]), (0, 0, 5.1)), 0).all()


def test_each_light_has_its_own_mask():
    view = scene(make_mesh("quad_and_triangle", 0, {}), (0, 0, -2), (0, 0, 0.4))
    assert shadow_mask(view, 0).any()
    np.testing.assert_array_equal(shadow_mask(view, 1), primary_hits(view).triangle == 2)


def test_coplanar_neighbours_do_not_shadow_each_other_under_grazing_light():
    """A tilted floor of many triangles, rounded to float32, away from the origin; the light 0.2 degrees above it."""
    random = np.random.default_rng(7)
    x, y = np.meshgrid(np.arange(33.0), np.arange(33.0))
    inner = random.uniform(-0.3, 0.3, (2, 33, 33))
    flat = np.stack([x + inner[0] - 16, y + inner[1] - 16, 0 * x], axis=-1).reshape(-1, 3) / 8
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    middle = point(1000, 2000, 500)
    first = (np.arange(32)[:, None] * 33 + np.arange(32)).ravel()
    cut = np.concatenate(
        [np.stack([first, first + 1, first + 34], 1), np.stack([first, first + 34, first + 33], 1)]
    )
    mesh = Mesh((middle + flat @ axes).astype(np.float32), cut.astype(np.int32))
    camera = Camera(middle + 3 * axes[2], middle, axes[1], 40.0, 0.01)
    light = middle + 90 * axes[0] + 0.3 * axes[2]
    mask = shadow_mask(scene(mesh, light, camera=camera, size=(160, 128)), 0)
    assert mask.mean() < 0.02  # rounding to float32 raises real ridges of some 1e-4 there


def tilted_triangle():
    """One triangle that fills the image, and a scene's camera; no coordinate of it is a round number."""
    axes = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    middle = point(103.1, 207.7, 55.3)
    corners = middle + np.array([(-9, -9, 0), (9, -9, 0), (0, 14, 0)]) @ axes
    mesh = soup(corners)
    rounded = mesh.vertices.astype(np.float64)
    normal = np.cross(rounded[1] - rounded[0], rounded[2] - rounded[0])
    normal /= np.linalg.norm(normal)
    return mesh, rounded.mean(axis=0), normal, axes[1]


def test_a_triangle_does_not_shadow_itself_when_the_light_is_all_but_in_its_plane():
    mesh, middle, normal, up = tilted_triangle()
    camera = Camera(middle + 3 * normal, middle, up, 40.0, 0.01)
    assert not shadow_mask(scene(mesh, middle + 1e-9 * normal, camera=camera), 0).any()


def test_twins_in_the_same_place_do_not_shadow_each_other():
    mesh, middle, normal, up = tilted_triangle()
    twins = Mesh(mesh.vertices, np.array([(0, 1, 2), (1, 2, 0), (2, 1, 0)], dtype=np.int32))
    camera = Camera(middle + 3 * normal, middle, up, 40.0, 0.01)
    assert not shadow_mask(scene(twins, middle + 2 * normal + up, camera=camera), 0).any()


def trace_by_trying_all(view, light_index):
    """Triangle seen, shadow, and whether either is a matter of rounding; by Cramer's rule for every pair."""
    corners = view.mesh.vertices[view.mesh.triangles].astype(np.float64)
    rays, light = pixel_rays(view.camera, view.width, view.height), view.lights[light_index].position
    shape = (view.height, view.width)
    triangle, shadow, close = np.full(shape, -1), np.zeros(shape, bool), np.zeros(shape, bool)
    for y, x in np.ndindex(shape):
        direction = rays.corner + x * rays.step_x + y * rays.step_y
        depth, unsure = meet_all(corners, rays.origin, direction, view.camera.near, np.inf)
        close[y, x] = unsure
        if not np.isfinite(depth).any():
            continue
        own = triangle[y, x] = np.argmin(depth)
        position = rays.origin + depth[own] * direction
        normal = np.cross(corners[own, 1] - corners[own, 0], corners[own, 2] - corners[own, 0])
        turned_away = (normal @ (rays.origin - corners[own, 0])) * (normal @ (light - corners[own, 0])) < 0
        others = np.delete(corners, own, axis=0)
        way, unsure = meet_all(others, position, light - position, clearance(position, rays.origin, light), 1)
        shadow[y, x] = turned_away or np.isfinite(way).any()
        close[y, x] |= unsure
    return triangle, shadow, close


def meet_all(corners, origin, direction, least, most):
    """Ray parameter of the hit with each triangle, inf for none; whether rounding could change any hit."""
    matrix = np.stack(
        [
            np.broadcast_to(-direction, (len(corners), 3)),
            corners[:, 1] - corners[:, 0],
            corners[:, 2] - corners[:, 0],
        ],
        axis=-1,
    )
    way, u, v = np.linalg.solve(matrix, (origin - corners[:, 0])[..., None])[..., 0].T
    slack = np.min([u, v, 1 - u - v, way - least, most - way], axis=0)
    return np.where(slack >= 0, way, np.inf), bool((np.abs(slack) < 1e-7).any())


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), number=st.integers(1, 60), light=st.tuples(*[st.floats(-2, 2)] * 3))
def test_the_tree_finds_what_trying_every_triangle_finds(seed, number, light):
    view = scene(random_soup(seed, number), light, size=(18, 14))
    triangle, shadow, close = trace_by_trying_all(view, 0)
    np.testing.assert_array_equal(primary_hits(view).triangle[~close], triangle[~close])
    np.testing.assert_array_equal(shadow_mask(view, 0)[~close], shadow[~close])
    assert close.mean() < 0.05


def test_the_soups_have_lit_and_dark_pixels():
    """So that the comparison above compares something."""
    view = scene(random_soup(1, 60), (0.5, 1.5, 2), size=(18, 14))
    triangle, shadow, _ = trace_by_trying_all(view, 0)
    assert shadow.sum() > 20
    assert ((triangle >= 0) & ~shadow).sum() > 20


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), number=st.integers(0, 300), near=st.floats(0.01, 3.5))
def test_rays_see_what_the_rasterizer_sees(seed, number, near):
    view = scene(random_soup(seed, number), camera=DOWN._replace(near=near), size=(40, 32))
    traced, raster = primary_hits(view), eye_view(view.mesh, view.camera, 40, 32)
    same = traced.triangle == raster.triangle
    assert (~same).sum() <= 1
    seen = same & (raster.triangle >= 0)
    np.testing.assert_allclose(1 / traced.depth[seen], raster.reciprocal_depth[seen], rtol=1e-6)
    np.testing.assert_array_equal(np.isinf(traced.depth), traced.triangle < 0)


@pytest.fixture(scope="module")
def level():
    camera = Camera(
        point(1142.4, 2716.8, 328.8), point(1143.1071, 2716.0929, 328.72), point(0, 0, 1), 75.0, 2.0
    )
    return scene(
        load_mesh("nx_bloodprison_8k9"),
        (1468.8, 2371.2, 528),
        (1603.2, 2102.4, 432),
        camera=camera,
        size=(320, 256),
    )


def test_rays_see_in_a_level_what_the_rasterizer_sees(level):
    traced, raster = primary_hits(level), eye_view(level.mesh, level.camera, 320, 256)
    same = traced.triangle == raster.triangle
    assert same.mean() > 0.999
    seen = same & (raster.triangle >= 0)
    np.testing.assert_allclose(1 / traced.depth[seen], raster.reciprocal_depth[seen], rtol=1e-6)


@pytest.mark.parametrize(("light", "lit"), [(0, 0.683), (1, 0.465)])
def test_part_of_a_level_that_is_lit(level, light, lit):
    """As measured once with another exact method, at another resolution."""
    raster = eye_view(level.mesh, level.camera, 320, 256)
    mask = shadow_mask(level, light, raster)
    assert (~mask & (raster.triangle >= 0)).mean() == pytest.approx(lit, abs=0.003)
    assert (mask != shadow_mask(level, light)).mean() < 0.001


def test_the_given_eye_view_decides_what_is_visible():
    view = scene(make_mesh("quad_and_triangle", 0, {}), (0.2, -0.1, 2))
    raster = eye_view(view.mesh, view.camera, view.width, view.height)
    nothing = raster._replace(triangle=np.full_like(raster.triangle, -1))
    assert not shadow_mask(view, 0, nothing).any()


def nodes_of(tree):
    """(node, depth) from the root down."""
    waiting = [(0, 0)]
    while waiting:
        node, depth = waiting.pop()
        yield node, depth
        if tree.number[node] == INNER:
            waiting += [(tree.first[node], depth + 1), (tree.first[node] + 1, depth + 1)]


def chain(number):
    """Triangles each half as large as the one before, towards a corner: the worst for a balanced tree."""
    return soup([np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1)]) * 2.0**-power for power in range(number)])


@pytest.mark.parametrize(
    "mesh",
    [random_soup(3, 200), chain(120), soup(np.tile([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (500, 1))), soup([])],
    ids=["random", "chain", "all the same", "empty"],
)
def test_a_tree_holds_every_triangle_once_within_its_boxes(mesh):
    tree = build_tree(mesh)
    assert sorted(tree.order) == list(range(len(mesh.triangles)))
    placed = np.zeros(len(mesh.triangles), dtype=int)
    for node, depth in nodes_of(tree):
        assert depth < 90
        if tree.number[node] == INNER:
            children = [tree.first[node], tree.first[node] + 1]
            assert (tree.low[node] == tree.low[children].min(axis=0)).all()
            assert (tree.high[node] == tree.high[children].max(axis=0)).all()
        else:
            places = slice(tree.first[node], tree.first[node] + tree.number[node])
            placed[places] += 1
            corners = tree.corners[tree.order[places]].reshape(-1, 3)
            assert (corners >= tree.low[node]).all()
            assert (corners <= tree.high[node]).all()
    assert (placed == 1).all()


def test_of_coincident_triangles_the_lower_is_seen():
    floor = [(-9, -9, 0), (9, -9, 0), (0, 9, 0)]
    assert (primary_hits(scene(soup([floor] * 40))).triangle == 0).all()


def test_coplanar_triangles_are_told_apart_as_the_rasterizer_does():
    random = np.random.default_rng(4)
    mesh = soup(np.append(random.uniform(-2, 2, (120, 2)), np.full((120, 1), 0.3), axis=1))
    camera = Camera(point(0.3, -2.1, 2.7), point(0.1, 0.2, 0.3), point(0, 0, 1), 60.0, 0.1)
    view = scene(mesh, camera=camera, size=(64, 48))
    raster = eye_view(mesh, camera, 64, 48)
    assert (raster.covered > 1).mean() > 0.2
    assert (primary_hits(view).triangle != raster.triangle).mean() < 0.001


def test_an_empty_mesh_is_all_background():
    view = scene(soup([]), (0, 0, 1))
    assert (primary_hits(view).triangle == -1).all()
    assert not shadow_mask(view, 0).any()


def test_rays_along_the_axes_find_walls():
    """Directions with zero components, origins in the planes of boxes."""
    wall = soup([[(-1, -1, 0), (1, -1, 0), (1, 1, 0)], [(-1, -1, 0), (1, 1, 0), (-1, 1, 0)]])
    view = scene(wall, (0, 0, 2), camera=DOWN._replace(eye=point(0, 0, 2)), size=(1, 1))
    assert primary_hits(view).depth.item() == 2
    assert not shadow_mask(view, 0).any()
