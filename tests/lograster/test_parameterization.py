"""Equations 1, 2, 5, 9, 10 and 11 against arithmetic of fifty digits."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from archsim.errors import ArchsimError
from archsim.lograster.grid import lost_rows, make_grid
from archsim.lograster.parameterization import (
    bits_bound,
    bits_needed,
    largest_ratio,
    log_unwarp,
    log_warp,
    smallest_step,
    unwarp_slope,
)

RATIOS = st.floats(1.001, 1e6)
PLACES = st.floats(0, 1)


def precise_unwarp(warped, ratio):
    """Eq. 5 with fifty digits, from the doubles that we get."""
    with localcontext() as context:
        context.prec = 50
        ratio, warped = Decimal(ratio), Decimal(warped)
        return ratio * (1 - (-warped * ratio.ln()).exp()) / (ratio - 1)


def precise_step(num_rows, ratio):
    """Eq. 9's Delta G_min = G(1) - G(1 - 1 / num_rows)."""
    with localcontext() as context:
        context.prec = 50
        return precise_unwarp(1, ratio) - precise_unwarp(1 - Decimal(1) / num_rows, ratio)


@given(PLACES, RATIOS)
def test_unwarp_is_equation_5(warped, ratio):
    assert float(log_unwarp(warped, ratio)) == pytest.approx(
        float(precise_unwarp(warped, ratio)), rel=1e-9, abs=1e-15
    )


@given(PLACES, RATIOS)
def test_warp_inverts_unwarp(warped, ratio):
    assert float(log_warp(log_unwarp(warped, ratio), ratio)) == pytest.approx(warped, abs=1e-9)


@given(PLACES, st.floats(1.001, 1e5))
def test_perspective_and_logarithm_make_pure_logarithmic_depth(place, ratio):
    """y' = ln(z/n) / ln(f/n) for the post-perspective y = f (z - n) / (z (f - n)), with n = 1."""
    z = ratio**place
    y = ratio * (z - 1) / (z * (ratio - 1))

    assert float(log_warp(y, ratio)) == pytest.approx(place, abs=1e-9)


@given(PLACES, st.floats(1.01, 1e5))
def test_the_slope_is_the_derivative(place, ratio):
    step = 1e-5
    difference = (log_unwarp(place + step, ratio) - log_unwarp(place - step, ratio)) / (2 * step)

    assert float(unwarp_slope(place, ratio)) == pytest.approx(float(difference), rel=1e-4)


@pytest.mark.parametrize(
    ("ratio", "excess"), [(10, 1.97), (100, 4.43), (1000, 7.17), (3.3e4, 11.63), (1e5, 13.08)]
)
def test_bits_of_a_4096_row_map(ratio, excess):
    """b_min - b_y is log2((R - 1) / ln R) as the rows get many; figures computed by hand."""
    needed = -float(precise_step(4096, ratio).ln()) / np.log(2)

    assert needed - 12 == pytest.approx(excess, abs=0.006)
    assert bits_needed(4096, ratio) == int(np.ceil(needed))
    assert float(smallest_step(4096, ratio)) == pytest.approx(float(precise_step(4096, ratio)), rel=1e-9)


@given(st.integers(4, 14), st.floats(1.0, 1e5))
def test_equation_10_bounds_the_bits(log_rows, ratio):
    exact = -np.log2(smallest_step(2**log_rows, ratio))

    assert exact <= bits_bound(2**log_rows, ratio) + 1e-9


def test_equation_10_fails_beyond_its_range():
    """0.8 log2 R grows more slowly than log2(R / ln R): the paper states the range up to 1e5."""
    assert -np.log2(smallest_step(4096, 1e6)) > bits_bound(4096, 1e6)


def test_equation_11_for_the_papers_map():
    assert largest_ratio(4096) == 2.0**15  # printed as about 3.3e4
    assert largest_ratio(4096) == pytest.approx(3.3e4, rel=0.01)


@pytest.mark.parametrize("rows", [256, 1024, 4096])
def test_rows_are_distinct_up_to_the_bound_and_collide_beyond(rows):
    bound = largest_ratio(rows)

    if bound <= 1e5:  # where eq. 10, from which it comes, is stated to hold
        assert lost_rows(make_grid(4, rows, bound)) == 0
    assert lost_rows(make_grid(4, rows, 100 * bound)) > 0


def test_fewer_bits_lose_rows():
    assert lost_rows(make_grid(4, 1024, 1000.0, bits=24)) == 0
    assert lost_rows(make_grid(4, 1024, 1000.0, bits=16)) > 0


def test_a_ratio_of_one_is_linear():
    linear, nearly = make_grid(8, 64), make_grid(8, 64, 1 + 1e-9)

    assert np.array_equal(linear.y, nearly.y)
    assert np.array_equal(linear.y, (2 * np.arange(64) + 1) << (24 - 7))


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        ((6, 8), "columns of a map must be a multiple of 4"),
        ((8, 0), "rows of a map"),
        ((8, 8, 0.5), "at least 1, not 0.5"),
        ((8, 8, float("nan")), "at least 1, not nan"),
        ((8, 8, 2.0, 27), "1 to 26 bits, not 27"),
    ],
)
def test_impossible_grids_are_refused(arguments, what):
    with pytest.raises(ArchsimError, match=what):
        make_grid(*arguments)
