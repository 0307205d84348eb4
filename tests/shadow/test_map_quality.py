"""Shadow maps of all kinds on a small scene: known depths, known order of errors, an irregular map without any."""

from __future__ import annotations

import numpy as np
import pytest

from archsim.config import load_scene as scene_config
from archsim.scene.mesh import Mesh
from archsim.scene.scene import load_scene
from archsim.shadow import map_quality
from archsim.shadow.adaptive_map import PAGE_TEXELS, Level, refine
from archsim.shadow.map_quality import ADAPTIVE, IRREGULAR, METHODS, quality, stage_of
from archsim.shadow.shadow_map import (
    NOTHING,
    Lookup,
    Receivers,
    ShadowMap,
    Surfaces,
    plane_numbers,
    shadowed,
)


@pytest.fixture(scope="module")
def points():
    scene = load_scene(scene_config("scenes/tiny.yaml", ["resolution=[64, 48]"]))
    return list(quality(stage_of(scene), [16, 64, 256], 4))


def errors(points, method):
    return [point.l2 for point in sorted(points) if point.method == method]


@pytest.mark.parametrize("method", [*METHODS, ADAPTIVE])
def test_more_samples_mean_a_better_picture(points, method):
    found = errors(points, method)
    assert found[-1] < 0.5 * found[0]


def test_irregular_maps_are_right_with_a_sample_a_pixel(points):
    (point,) = [point for point in points if point.method == IRREGULAR]
    assert point.num_samples == 64 * 48
    assert point.l2 < 0.1 * min(each.l2 for each in points if each.method != IRREGULAR)


def test_adaptive_maps_need_fewer_samples_than_conventional_ones(points):
    adaptive = max(
        (point for point in points if point.method == ADAPTIVE), key=lambda point: point.num_samples
    )
    conventional = [point for point in points if point.method == "PCF 3 x 3" and point.num_samples == 256**2]
    assert adaptive.l2 <= 1.05 * conventional[0].l2
    assert adaptive.num_samples < conventional[0].num_samples


MAP = ShadowMap(np.full((4, 4), 0.25, np.float32), np.zeros((4, 4), np.int32))
MAP.depth[:, 2:], MAP.triangle[:, 2:] = np.inf, NOTHING
SURFACES = Surfaces(np.array([0.125], np.float32), np.array([7], np.int32))


def one(x, depth, plane=0):
    return Receivers(np.array([[x, 1.5, depth]], np.float32), np.array([plane], np.int32))


@pytest.mark.parametrize(
    ("receiver", "lookup", "share"),
    [
        (one(1.5, 0.5), Lookup(0, 0.0, 0.0, False), 1),
        (one(1.5, 0.25), Lookup(0, 0.0, 0.0, False), 0),
        (one(2.5, 0.5), Lookup(0, 0.0, 0.0, False), 0),
        (one(1.5, 0.5), Lookup(1, 0.0, 0.0, False), 6 / 9),
        (one(0.5, 0.5), Lookup(1, 0.0, 0.0, False), 1),
        (one(1.5, 0.5), Lookup(0, 2.0, 0.0, False), 0),
        (one(1.5, 0.5), Lookup(0, 1.0, 0.0625, False), 1),
        (one(1.5, 0.5), Lookup(0, 1.0, 0.25, False), 0),
        (one(1.5, 0.5, plane=7), Lookup(0, 0.0, 0.0, True), 0),
        (one(1.5, 0.5, plane=8), Lookup(0, 0.0, 0.0, True), 1),
        (one(np.nan, np.nan), Lookup(1, 0.0, 0.0, False), 0),
    ],
)
def test_lookups(receiver, lookup, share):
    assert shadowed(MAP, SURFACES, receiver, lookup)[0] == pytest.approx(share)


def test_triangles_of_one_plane_share_a_number():
    vertices = np.array([(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1), (0, 0, 2)], np.float32)
    triangles = np.array([(0, 1, 2), (0, 3, 2), (0, 1, 4)], np.int32)  # the second faces the other way
    first, second, third = plane_numbers(Mesh(vertices, triangles))
    assert first == second != third


def level(pages_wide, page, doubts):
    page = np.array(page, np.int64)
    return Level(page, pages_wide, np.full(len(page), float(pages_wide)), np.array(doubts, np.int64))


def test_the_page_with_most_doubts_is_refined_first():
    found = [level(1, [0, 0], [2]), level(2, [0, 3], [1, 0, 0, 5]), level(4, [0, 15], [0] * 16)]
    page = PAGE_TEXELS**2
    sizes = list(refine(found, [page, 4 * page, 7 * page, 100 * page]))
    assert [each.num_texels for each in sizes] == [page, 4 * page, 7 * page, 10 * page]
    assert [each.shadowed.tolist() for each in sizes] == [[1, 1], [2, 2], [2, 4], [4, 4]]


def test_the_view_is_as_narrow_as_the_samples_allow():
    scene = load_scene(scene_config("scenes/bloodprison.yaml", ["resolution=[64, 48]"]))
    assert all(light.view is None for light in map_quality.stage_of(scene).scene.lights)
