"""The evaluator designs: their cost, counted by hand, and where they put the rows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from archsim.errors import ArchsimError
from archsim.lograster.evaluators import Design, EvaluatorSpec, evaluator_cost, row_error, with_rows
from archsim.lograster.grid import lost_rows, make_grid
from archsim.lograster.parameterization import largest_ratio

SPEC = EvaluatorSpec(Design.FULL, 4, exponential_cycles=11, multiply_cycles=3, table_ports=4, table_cycles=2)


def test_full_evaluation_takes_four_exponentials_a_clock():
    cost = evaluator_cost(SPEC, rows=4096, bits=24)

    assert cost.exponentials == 4
    assert cost.multipliers == 4 * 4  # three edges and depth in four rows
    assert cost.adders == 4 * 12
    assert cost.table_bytes == 0
    assert cost.latency_cycles == 11 + 3 + 1
    assert cost.interval_cycles == 1


def test_incremental_evaluation_takes_one_and_is_later():
    cost = evaluator_cost(SPEC._replace(design=Design.INCREMENTAL, exponentials=1), rows=4096, bits=24)

    assert (cost.exponentials, cost.multipliers) == (1, 16 + 3)
    assert cost.latency_cycles == 11 + 3 + 3 + 1
    assert cost.interval_cycles == 1


def test_the_table_of_all_rows_is_large_and_that_of_first_rows_a_quarter():
    table = evaluator_cost(SPEC._replace(design=Design.TABLE), rows=4096, bits=24)
    first_rows = evaluator_cost(SPEC._replace(design=Design.TABLE_FIRST_ROW), rows=4096, bits=24)

    assert (table.table_bytes, first_rows.table_bytes) == (12288, 3072)
    assert (table.table_reads, first_rows.table_reads) == (4, 1)
    assert (table.latency_cycles, first_rows.latency_cycles) == (2 + 3 + 1, 2 + 3 + 3 + 1)


@pytest.mark.parametrize(
    ("design", "exponentials", "ports", "interval"),
    [
        (Design.FULL, 1, 1, 4),
        (Design.FULL, 3, 1, 2),
        (Design.TABLE, 1, 2, 2),
        (Design.TABLE_FIRST_ROW, 1, 1, 1),
    ],
)
def test_too_few_units_do_not_sustain_a_tile_a_clock(design, exponentials, ports, interval):
    spec = SPEC._replace(design=design, exponentials=exponentials, table_ports=ports)

    assert evaluator_cost(spec, 1024, 24).interval_cycles == interval


@given(
    st.sampled_from([256, 1024, 4096]),
    st.floats(0, 1),
    st.sampled_from([Design.INCREMENTAL, Design.TABLE_FIRST_ROW]),
)
def test_incremental_rows_are_within_one_step_and_distinct(rows, part, design):
    """With constants four bits longer than the coordinates eq. 7 moves no row by more than one grid step."""
    grid = make_grid(4, rows, min(largest_ratio(rows), 1e5) ** part)

    assert row_error(grid, design, 28) <= 1
    assert (np.diff(with_rows(grid, design, 28).y) >= 0).all()


def test_constants_that_are_too_short_move_rows():
    grid = make_grid(4, 1024, 1000.0)

    assert row_error(grid, Design.INCREMENTAL, 12) > 100


def test_at_the_bound_incremental_constants_need_26_bits():
    """Eq. 11's largest f/n leaves less than a bit of room: 24-bit constants use it up and lose a row, 26-bit
    ones do not.
    """
    grid = make_grid(4, 4096, largest_ratio(4096))

    lost = {bits: lost_rows(with_rows(grid, Design.INCREMENTAL, bits)) for bits in (24, 26)}

    assert lost_rows(with_rows(grid, Design.FULL, 24)) == 0
    assert lost == {24: 1, 26: 0}


def test_impossible_evaluators_are_refused():
    with pytest.raises(ArchsimError, match="at least one exponential unit"):
        evaluator_cost(SPEC._replace(exponentials=0), 64, 24)
    with pytest.raises(ArchsimError, match="at least one clock"):
        evaluator_cost(SPEC._replace(multiply_cycles=0), 64, 24)
    with pytest.raises(ArchsimError, match="1 to 36 bits, not 40"):
        with_rows(make_grid(4, 64, 10.0), Design.INCREMENTAL, 40)
