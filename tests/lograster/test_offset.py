"""Generalized polygon offset: eq. 12 to 14 against derivatives taken numerically, and the three treatments."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from archsim.lograster.depth_buffer import steepness
from archsim.lograster.grid import make_grid
from archsim.lograster.offset import (
    OffsetSpec,
    Slopes,
    Switch,
    excess,
    larger_slope,
    offset_depth,
    offset_depth_at,
    slopes,
    switch_position,
)
from archsim.lograster.parameterization import log_unwarp, log_warp
from archsim.lograster.setup import DepthPlane

PARTS = st.floats(0, 1)
RATIOS = st.floats(1.5, 1e4)


def plane(dx, dy, constant=0.2):
    return DepthPlane(constant, dx, dy, -100.0, 100.0)


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.01, 0.99), RATIOS)
def test_slopes_are_the_changes_of_depth_from_texel_to_texel(dx, dy, warped, ratio):
    """Eq. 12 and 13: m_z as the larger difference of depths half a texel each way."""
    columns, rows = 64, 1 << 14
    inclination = slopes(plane(dx, dy), columns, rows, steepness(make_grid(columns, rows, ratio)))
    ends = log_unwarp(np.array([warped - 0.5 / rows, warped + 0.5 / rows]), ratio)
    along = abs(dy) * (ends[1] - ends[0])

    ours = larger_slope(inclination, float(log_unwarp(warped, ratio)))

    assert ours == pytest.approx(max(abs(dx) / columns, along), rel=1e-4, abs=1e-12)


@given(st.floats(0.001, 1), st.floats(0.001, 1), PARTS, PARTS, RATIOS)
def test_interpolated_offset_is_conservative_and_right_at_the_ends(dx, dy, one, other, ratio):
    y0, y1 = sorted((one, other))
    assume(y1 - y0 > 1e-3)
    inclination = slopes(plane(dx, dy), 64, 64, steepness(make_grid(64, 64, ratio)))
    spec = OffsetSpec(1.0, 0.0, int(Switch.INTERPOLATED))
    interpolated = offset_depth(plane(0.0, 0.0, 0.0), inclination, y0, y1, spec)

    places = np.linspace(y0, y1, 33)
    ours = np.array([offset_depth_at(interpolated, 0.0, y) for y in places])
    true = np.array([larger_slope(inclination, y) for y in places])

    assert (ours >= true * (1 - 1e-9)).all()
    assert ours[[0, -1]] == pytest.approx(true[[0, -1]])
    measured = ((ours - true) / true).max()
    assert measured <= excess(inclination, y0, y1) + 1e-9


@given(st.floats(0.001, 1), st.floats(0.001, 1), PARTS, RATIOS)
def test_two_planes_and_split_give_the_true_slope(dx, dy, y, ratio):
    inclination = slopes(plane(dx, dy), 64, 64, steepness(make_grid(64, 64, ratio)))
    true = 3.0 * larger_slope(inclination, y) + 0.25

    for switch in (Switch.TWO_PLANES, Switch.SPLIT):
        offset = offset_depth(plane(0.0, 0.0, 0.0), inclination, 0.0, 1.0, OffsetSpec(3.0, 0.25, int(switch)))
        assert offset_depth_at(offset, 0.5, y) == pytest.approx(true)


def test_the_excess_is_about_1_for_a_triangle_over_the_whole_map():
    """y1 - y0 = 1: with a switch at y the excess is nearly y, so near 1 at most. [Lloyd07] sec. 4.2.5"""
    ratio = 1e4
    warped_switch = 0.6
    along = 1.0
    y = float(log_unwarp(warped_switch, ratio))
    change = -along * (1 - 1 / ratio)
    inclination = Slopes(along + change * y, along, change)

    assert switch_position(inclination) == pytest.approx(y)
    assert float(log_warp(switch_position(inclination), ratio)) == pytest.approx(warped_switch)
    assert 0.9 < excess(inclination, 0.0, 1.0) < 1.0
    assert excess(inclination, y - 0.01, y + 0.001) < 0.9
    assert excess(inclination, 0.0, y / 2) == 0.0


def test_without_a_switch_all_treatments_agree():
    flat_across = slopes(plane(0.0, 1.0), 64, 64, steepness(make_grid(64, 64, 100.0)))
    for y in (0.1, 0.5, 0.9):
        values = {
            round(
                offset_depth_at(
                    offset_depth(plane(0.0, 1.0), flat_across, 0.0, 1.0, OffsetSpec(1.0, 0.0, int(switch))),
                    0.0,
                    y,
                ),
                12,
            )
            for switch in Switch
        }
        assert len(values) == 1


@given(st.floats(0.01, 0.99), st.floats(0.001, 0.2), st.floats(0.01, 0.99), st.floats(2, 1e4))
def test_what_interpolation_exceeds_by_is_the_extent_of_the_triangle(middle, extent, part, ratio):
    """part (1 - part) times the change of |dz/dy'| over the triangle, relative to |dz/dx|: the reason why the mean
    over a scene (table 4 of the reproduction) follows the size of its triangles.
    """
    along_y = -(1 - 1 / ratio)
    y0, y1 = middle - part * extent, middle + (1 - part) * extent
    across = 1 + along_y * middle  # both slopes are equal at `middle`
    assume(y0 > 0 and y1 < 1)

    assert excess(Slopes(across, 1.0, along_y), y0, y1) == pytest.approx(
        part * (1 - part) * -along_y * extent / across, rel=1e-6, abs=1e-12
    )


@pytest.mark.parametrize("strips", [100, 300, 1151])
def test_the_mean_falls_as_triangles_get_smaller(strips):
    """Strips of equal depth ratio over a map with f/n = 1000, the switch anywhere: a sixth of the share of its distance
    that a strip reaches over. The paper's 0.001 takes 1151 strips, each of 0.6 % of its distance.
    """
    span = 1 - 1 / 1000.0
    ends = (1 - 1000.0 ** -(np.arange(strips + 1) / strips)) / span
    places = (1 - 1 / np.geomspace(1.01, 990, 4999)) / span
    first = np.searchsorted(ends, places) - 1

    found = [
        excess(Slopes(1 - y * span, 1.0, -span), ends[k], ends[k + 1])
        for y, k in zip(places, first, strict=True)
    ]

    assert np.mean(found) == pytest.approx(np.log(1000.0) / strips / 6, rel=0.05)
