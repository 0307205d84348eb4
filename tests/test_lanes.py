"""Eight numbers at a time say the same as one by one."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from archsim.jit import njit
from archsim.lanes import LANES, equal_lanes, least_lane, padded

NUMBERS = st.sampled_from([0, 1, -1, 7, ~7, 1 << 62, -(1 << 62), (1 << 63) - 1, -(1 << 63)])
TABLES = arrays(np.int64, (3, 2 * LANES), elements=NUMBERS)
ROWS, FIRSTS = st.integers(0, 2), st.integers(0, LANES)


@njit
def _equal(table, row, first, one, other):
    return equal_lanes(table, row, first, one, other)


@njit
def _least(table, row, first, but):
    return least_lane(table, row, first, but)


@given(TABLES, ROWS, FIRSTS, NUMBERS, NUMBERS)
def test_equal_lanes(table, row, first, one, other):
    expected = [number in (one, other) for number in table[row, first : first + LANES].tolist()]
    bits = sum(1 << lane for lane, is_equal in enumerate(expected) if is_equal)
    assert _equal(table, row, first, one, other) == equal_lanes(table, row, first, one, other) == bits


@given(TABLES, ROWS, FIRSTS, st.integers(-1, LANES))
def test_least_lane(table, row, first, but):
    lanes = table[row, first : first + LANES].tolist()
    expected = min(number for lane, number in enumerate(lanes) if lane != but)
    assert _least(table, row, first, but) == least_lane(table, row, first, but) == expected


def test_padded():
    assert [padded(length) for length in (0, 1, 8, 9)] == [0, 8, 8, 16]
