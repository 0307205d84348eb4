"""m against closed forms and against texels projected point by point; and how storage grows with f/n."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.shadowmap.allocation import balanced, equal, needed
from archsim.shadowmap.error import owner, places, space_error, surface_error
from archsim.shadowmap.families import FAMILIES, make_maps
from archsim.shadowmap.view import at_depth, directional_light, volume_samples

from .views import DIRECTIONS, OVERHEAD, view_of

ROWS = 512


def on_line_of_sight(view, depths):
    return at_depth(view, np.zeros(len(depths)), np.zeros(len(depths)), np.asarray(depths))


def test_a_standard_map_under_an_overhead_light_by_hand():
    """Along: (f - n) / (2 z tan) pixels a map; across: f / z. [Lloyd07] sec. 3.2's O((f/n)^2)"""
    view = view_of(100)
    depths = np.array([1.0, 3.0, 50.0, 100.0])
    across, along = space_error(
        make_maps("standard", view, OVERHEAD)[0], view, on_line_of_sight(view, depths), ROWS
    )

    assert along == pytest.approx(ROWS * 99 / (2 * depths * view.tan_y))
    assert across == pytest.approx(ROWS * 100 / depths)


def test_a_logarithmic_map_has_the_same_error_at_every_depth():
    """ln(f/n) / (2 tan) along and 1 across, times the sine of the face's tilt along."""
    view = view_of(100)
    bottom = next(m for m in make_maps("logpsm", view, OVERHEAD) if m.name == "bottom")
    across, along = space_error(bottom, view, on_line_of_sight(view, [1.0, 3.0, 50.0, 99.0]), ROWS)

    assert along == pytest.approx(ROWS * math.log(100) / (2 * view.tan_y))
    assert across == pytest.approx(ROWS)


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(sorted(FAMILIES)), DIRECTIONS, st.integers(0, 2**31))
def test_m_on_surfaces_is_what_projected_texels_measure(family, light, seed):
    """Walk from a point on its surface until the map coordinate has changed by a tiny texel; measure in the
    image.
    """
    view = view_of(20)
    random = np.random.default_rng(seed)
    points = volume_samples(view, 5, 7)[random.integers(0, 5 * 5 * 7, 6)] * 0.999 + 0.001 * np.array(
        [0, 10, 0]
    )
    normals = random.normal(size=(6, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[np.abs(normals @ light[:3]) < 0.2] = light[:3]
    maps = make_maps(family, view, light)
    for index in np.unique(owner(maps, points)):
        mine = owner(maps, points) == index
        ours = surface_error(maps[index], (1 << 20, 1 << 20), view, points[mine], normals[mine], ROWS)
        measured = [
            texel_extent(maps[index], view, *pair) for pair in zip(points[mine], normals[mine], strict=True)
        ]
        assert ours == pytest.approx(np.array(measured), rel=2e-3)


def texel_extent(shadow_map, view, point, normal):
    """The longer side in pixels of the texel of a 2^20 x 2^20 map around a point, by Newton's method on the
    surface.
    """
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    start = places(shadow_map, point[None])

    def place(a, b):
        here = places(shadow_map, (point + a * u + b * v)[None])
        return np.array([here.x[0] - start.x[0], here.y[0] - start.y[0]])

    lengths = []
    for goal in (np.array([2.0**-20, 0]), np.array([0, 2.0**-20])):
        step = np.zeros(2)
        width = 1e-4
        for _ in range(6):
            slope = np.stack(
                [
                    (place(*(step + d)) - place(*(step - d))) / (2 * width)
                    for d in (np.array([width, 0]), np.array([0, width]))
                ],
                axis=1,
            )
            step = step + np.linalg.solve(slope, goal - place(*step))
        lengths.append(np.linalg.norm(pixel(view, point + step[0] * u + step[1] * v) - pixel(view, point)))
    return max(lengths)


def pixel(view, point):
    inside = view.axes @ (point - view.eye)
    return inside[:2] / inside[2] * ROWS / (2 * view.tan_y)


@pytest.mark.parametrize(
    ("family", "low", "high"), [("standard", 1.95, 2.05), ("lispsm", 0.95, 1.05), ("fp_lispsm", 0.95, 1.05)]
)
def test_storage_grows_with_the_papers_powers(family, low, high):
    """[Lloyd07] sec. 3.2: O((f/n)^2) for standard, O(f/n) for perspective parameterizations."""
    light = directional_light(np.array([0.01, 0.02, 1.0]))
    storage = [
        needed(make_maps(family, view_of(r), light), view_of(r), ROWS).prod(axis=1).sum()
        for r in (100, 10_000)
    ]

    assert low < math.log(storage[1] / storage[0]) / math.log(100) < high


def test_storage_of_logarithmic_maps_grows_with_the_logarithm():
    light = directional_light(np.array([0.01, 0.02, 1.0]))
    ratios = (10, 100, 1000, 10_000)
    storage = [
        needed(make_maps("logpsm", view_of(r), light), view_of(r), ROWS).prod(axis=1).sum() for r in ratios
    ]

    steps = np.diff(storage)
    assert steps == pytest.approx(steps[0], rel=0.02)  # the same for every factor of ten
    assert steps[0] / ROWS**2 == pytest.approx(math.log(10) / (2 * view_of(10).tan_y), rel=0.25)


def test_balanced_sizes_have_the_same_largest_error_everywhere():
    view = view_of(1000)
    maps = make_maps("logpsm", view, directional_light(np.array([0.5, -0.6, 1.0])))
    wanted = needed(maps, view, ROWS)
    sizes = balanced(wanted, 1 << 22)
    worst = [
        max(need / size for need, size in zip(pair, given, strict=True))
        for pair, given in zip(wanted, sizes, strict=True)
    ]

    assert max(worst) / min(worst) < 1.05
    assert sum(columns * rows for columns, rows in sizes) == pytest.approx(1 << 22, rel=0.05)


def test_equal_sizes():
    assert equal(4, 4 * 64 * 64) == [(64, 64)] * 4
    assert equal(5, 512 * 512)[0] == (228, 228)
