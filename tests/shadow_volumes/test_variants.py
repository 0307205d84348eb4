"""All variants give the same shadow mask in every pixel, and it is the ray tracer's."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from archsim.scene.mesh import Mesh
from archsim.scene.scene import Scene
from archsim.shadow_volumes.casters import Grouping
from archsim.shadow_volumes.comparison import BRUTE_FORCE, COMBINED, HIERARCHICAL, VARIANTS, draw
from archsim.shadow_volumes.hierarchical import Resources
from archsim.shadow_volumes.psv_cache import CacheShape
from archsim.shadow_volumes.volumes import Counting
from tests.shadow.scenes import soup
from tests.shadow_volumes.scenes import (
    BOX,
    BOX_TRIANGLES,
    RESOURCES,
    all_masks,
    floor_and,
    make_scene,
    method,
    prepared,
    traced,
)

SIZES = st.tuples(st.integers(1, 70), st.integers(1, 50))
GROUPINGS, COUNTINGS = st.sampled_from(list(Grouping)), st.sampled_from(list(Counting))


def assert_equal_masks(scene, chosen):
    masks = all_masks(scene, chosen)
    for name, mask in masks.items():
        different = int((mask != masks[BRUTE_FORCE]).sum())
        assert different == 0, f"{name}: {different} pixels differ from brute force"
    return masks[BRUTE_FORCE]


@settings(deadline=None, max_examples=100)
@given(
    st.integers(0, 2**31),
    SIZES,
    GROUPINGS,
    COUNTINGS,
    st.sampled_from([4, 8, 16]),
    st.integers(1, 3),
    st.sampled_from([60, 1 << 20]),
)
# tiles that share a sample disagree
@example(129, (45, 33), Grouping.PARTS, Counting.ADAPTIVE, 4, 1, 1 << 20)
@example(199, (53, 40), Grouping.TRIANGLES, Counting.ADAPTIVE, 4, 1, 1 << 20)
def test_random_triangles(seed, size, grouping, counting, tile, num_buffers, stream_bytes):
    scene = soup(seed, 4 + seed % 12, size)
    resources = Resources(num_buffers, CacheShape(64, 32, 1), stream_bytes)
    mask = assert_equal_masks(scene, method(grouping, counting, tile=tile, resources=resources))
    assert (mask != traced(scene)).mean() < 0.01


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 2**31), COUNTINGS, st.floats(0.01, 50))
@example(392381, Counting.Z_FAIL, 7.0)  # its volume's end bulges out of that of its box
def test_volumes_that_end_at_a_range(seed, counting, reach):
    assert_equal_masks(soup(seed), method(counting=counting, reach=reach))


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 2**31), GROUPINGS, COUNTINGS)
def test_closed_boxes_that_overlap(seed, grouping, counting):
    rng = np.random.default_rng(seed)
    vertices, triangles = [], []
    for number in range(5):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0] * rng.uniform(0.2, 1.5)
        vertices.append((np.array(BOX) - 0.5) @ turn + rng.uniform(-2, 2, 3))
        triangles.append(np.array(BOX_TRIANGLES) + 8 * number)
    mesh = Mesh(np.concatenate(vertices).astype(np.float32), np.concatenate(triangles).astype(np.int32))
    scene = soup(seed)._replace(mesh=mesh)
    mask = assert_equal_masks(scene, method(grouping, counting))
    assert (mask != traced(scene)).mean() < 0.01


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 2**31), COUNTINGS)
def test_corners_on_a_coarse_grid_meet_pixel_centres_and_each_other(seed, counting):
    rng = np.random.default_rng(seed)
    vertices = rng.integers(-2, 3, (14, 3))
    triangles = rng.integers(0, 14, (10, 3))  # degenerate and double ones among them
    eye = rng.integers(-3, 4, 3) + 0.5 * rng.integers(0, 2)
    target = eye + np.eye(3)[rng.integers(3)] * rng.choice([-1, 1])
    up = np.roll(np.abs(target - eye), 1)
    light = rng.integers(-4, 5, 3)
    scene = make_scene(vertices, triangles, eye, target, light, (32, 32), up=up)
    assert_equal_masks(scene, method(counting=counting))


def corner_cases():
    """(name, scene) of views that shadow volumes find hard."""
    big = [(-9, -9, 4), (9, -9, 4), (0, 9, 4)]
    vertices, triangles, _ = floor_and(big, [(0, 1, 2)])
    yield "eye inside a volume", make_scene(vertices, triangles, (0, -3, 1), (0, 0, 0.5), (0, 0, 9))
    yield "light in the view", make_scene(vertices, triangles, (0, -8, 2), (0, 0, 4), (0, 0, 6))
    vertices, triangles, _ = floor_and([(-1, -3, 1), (1, -3, 1.02), (0, 5, 1)], [(0, 1, 2)])
    yield (
        "caster across the near plane",
        make_scene(vertices, triangles, (0, -2.9, 1), (0, 3, 0.9), (0, 0, 3)),
    )
    vertices, triangles, _ = floor_and(BOX, BOX_TRIANGLES)
    yield "light inside a caster", make_scene(vertices, triangles, (4, -4, 3), (0, 0, 0), (0.5, 0.5, 0.5))
    yield (
        "eye and light inside",
        make_scene(vertices, triangles, (0.4, 0.4, 0.5), (1, 1, 0.5), (0.6, 0.5, 0.9), near=0.01),
    )
    yield (
        "light in a caster's plane",
        make_scene(vertices, triangles, (4, -4, 3), (0, 0, 0), (3.0, 0.25, 1.0)),
    )
    yield "light at a vertex", make_scene(vertices, triangles, (4, -4, 3), (0, 0, 0), (1.0, 1.0, 1.0))
    yield "light far away", make_scene(vertices, triangles, (4, -4, 3), (0, 0, 0), (5e8, 3e8, 7e8))
    yield "nothing to see", make_scene(vertices, triangles, (0, 0, 9), (0, 0, 20), (3, 3, 3), up=(0, 1, 0))
    double = [*BOX_TRIANGLES, *BOX_TRIANGLES, *[t[::-1] for t in BOX_TRIANGLES]]
    yield "doubled faces", make_scene(BOX, double, (4, -4, 3), (0, 0, 0), (3, 2, 5))
    yield "one pixel", make_scene(vertices, triangles, (4, -4, 3), (0, 0, 0), (3, 2, 5), size=(1, 1))


@pytest.mark.parametrize("counting", list(Counting))
@pytest.mark.parametrize(("name", "scene"), list(corner_cases()), ids=lambda value: str(value)[:30])
def test_corner_cases(name, scene, counting):
    for chosen in (method(counting=counting), method(Grouping.TRIANGLES, counting)):
        mask = assert_equal_masks(scene, chosen)
    assert (mask != traced(scene)).mean() < 0.01, name


def test_a_shadow_on_the_floor_is_where_it_belongs():
    """A square of side 2 at half the light's height throws one of side 4."""
    square = [(-1, -1, 5), (1, -1, 5), (1, 1, 5), (-1, 1, 5)]
    vertices, triangles, objects = floor_and(square, [(0, 1, 2), (0, 2, 3)])
    scene = make_scene(
        vertices, triangles, (0, 0, 4), (0, 0, 0), (0, 0, 10), (80, 80), up=(0, 1, 0), objects=objects
    )
    for mask in all_masks(scene).values():
        across = 4 * 80 / (2 * 4 * np.tan(np.radians(30)))  # pixels
        assert abs(mask.sum() - across**2) < 4 * across
        assert mask[40, 40]
        assert not mask[2, 2]


def test_hierarchical_work_grows_with_the_boundary_and_brute_force_with_the_area():
    square = [(-1, -1, 5), (1, -1, 5), (1, 1, 5), (-1, 1, 5)]
    vertices, triangles, objects = floor_and(square, [(0, 1, 2), (0, 2, 3)])
    pixels = {}
    for side in (128, 512):
        scene = make_scene(
            vertices, triangles, (0, 0, 4), (0, 0, 0), (0, 0, 10), (side, side), up=(0, 1, 0), objects=objects
        )
        view = prepared(scene)
        pixels[side] = [draw(view, name, RESOURCES).traffic.stencil_pixels for name in VARIANTS]
    assert 15 < pixels[512][0] / pixels[128][0] < 17
    assert 3 < pixels[512][2] / pixels[128][2] < 5


def overflowing(stream_bytes):
    """Traffic of a closed box' shadow with a delay stream of so many bytes."""
    vertices, triangles, objects = floor_and(BOX, BOX_TRIANGLES)
    scene = make_scene(
        vertices, triangles, (2, -2, 4), (0.5, 0.5, 0), (0.5, 0.6, 3), (160, 120), objects=objects
    )
    resources = RESOURCES._replace(delay_stream_bytes=stream_bytes)
    view = prepared(scene)
    hierarchical = draw(view, HIERARCHICAL, resources)
    assert (hierarchical.shadow == draw(view, BRUTE_FORCE, resources).shadow).all()
    return hierarchical.traffic, draw(view, BRUTE_FORCE, resources).traffic


def test_a_delay_stream_that_overflows_costs_pixels_but_not_more_than_brute_force():
    steps = [overflowing(size) for size in (10_000, 150, 60, 14)]
    hierarchical = [own.stencil_pixels for own, _ in steps]
    assert hierarchical == sorted(hierarchical)
    assert hierarchical[0] < 0.5 * hierarchical[-1]
    assert hierarchical[-1] <= steps[0][1].stencil_pixels


def test_traffic_is_made_of_the_printed_sizes():
    """2 bytes a stencil pixel, 128 bytes a tile of compressed depths, 1 byte a lit pixel or 64 a mixed tile."""
    own, brute = overflowing(10_000)
    assert brute.stencil_shadow == 2 * brute.stencil_pixels
    assert brute.depth_shadow % 128 == own.depth_shadow % 128 == 0
    assert brute.stencil_lighting == 160 * 120  # the floor fills the view
    assert own.stencil_lighting % 64 == 0
    assert brute.total == brute.stencil_shadow + brute.depth_shadow + brute.stencil_lighting
    assert own.depth_shadow <= brute.depth_shadow
    assert own.processed == own.stencil_pixels + own.sample_operations


def test_tiles_in_full_shadow_are_skipped_by_later_volumes():
    """Two equal squares, one below the other: the second costs no pixels where the first one's shadow is."""
    square = np.array([(-1, -1, 5), (1, -1, 5), (1, 1, 5), (-1, 1, 5)], float)
    lower = square * (0.4, 0.4, 0.6)  # inside the upper one's volume
    both = np.concatenate([square, lower])
    vertices, triangles, _ = floor_and(both, [(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)])
    objects = np.array([-1, -1, 0, 0, 1, 1], np.int32)

    def pixels(order):
        scene = make_scene(vertices, triangles, (0, -5, 4), (0, 0, 0), (0, 0, 10), (320, 240))
        mesh = Mesh(scene.mesh.vertices, scene.mesh.triangles[order], objects)
        scene = Scene(mesh, *scene[1:])
        return draw(prepared(scene), HIERARCHICAL, RESOURCES).traffic

    larger_first, smaller_first = pixels([0, 1, 2, 3, 4, 5]), pixels([0, 1, 4, 5, 2, 3])
    assert larger_first.stencil_pixels < smaller_first.stencil_pixels
    assert larger_first.depth_shadow < smaller_first.depth_shadow


def test_depth_bounds_discard_tiles_before_stage_1():
    scene = soup(25, 12, (160, 120))
    view = prepared(scene, method(Grouping.TRIANGLES))
    alone, together = (draw(view, name, RESOURCES).traffic for name in (HIERARCHICAL, COMBINED))
    assert together.sample_operations < alone.sample_operations
    assert together.stencil_pixels <= alone.stencil_pixels


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_stencil_operation_is_a_layer_of_its_pixel(variant):
    drawn = draw(prepared(soup(25, 12, (160, 120))), variant, RESOURCES)
    assert drawn.layers.shape == (120, 160)
    assert drawn.layers.sum() == drawn.traffic.stencil_pixels > 0


def test_only_brute_force_draws_where_there_is_no_boundary():
    view = prepared(soup(25, 12, (160, 120)))
    own, brute = (draw(view, variant, RESOURCES).layers for variant in (HIERARCHICAL, BRUTE_FORCE))
    assert (own <= brute).all()
    assert own.sum() < brute.sum()
