"""Pareto front, knee and sensitivity, by hand and against their definitions."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from archsim.errors import ArchsimError
from archsim.sweep.analysis import AS_IN_THE_RUN, amounts, finding, in_order, knee, pareto_front, sensitivity


def table(**columns) -> pd.DataFrame:
    frame = pd.DataFrame(columns)
    frame["status"] = "finished"
    return frame


BY_HAND = table(size=["4 KiB", "1 KiB", "2 KiB", "2 KiB"], cycles=[10, 100, 20, 30], threads=[1, 2, 1, 2])


def test_the_front_is_sorted_and_leaves_out_what_is_beaten():
    front = pareto_front(BY_HAND, ["size", "cycles"])

    assert front["cycles"].tolist() == [100, 20, 10]
    assert knee(front, ["size", "cycles"]) == 1


def test_a_finding_by_hand():
    """Means: 15 and 65 by threads, 10, 100 and 25 by size, over 40; `ways` always goes with `size`."""
    points = BY_HAND.assign(ways=[8, 2, 4, 4])
    assert finding(points, ["threads", "size", "ways"], "cycles") == (
        "cycles is least, 10, with threads 1, size 4 KiB; most, 100 (+900 %), with threads 2, size 1 KiB. "
        "Its means differ by 225 % over size, 125 % over threads."
    )


def test_parameters_of_some_points_move_nothing():
    points = table(cycles=[10, 20, 15], banks=[np.nan, 8, np.nan], order=["a", None, None])
    assert finding(points, ["banks", "order"], "cycles") == (
        "cycles is least, 10, with order a; most, 20 (+100 %), with banks 8."
    )


@pytest.mark.parametrize(
    ("cycles", "sentence"),
    [([7], "cycles: one point says nothing."), ([7, 7], "cycles is 7 at all 2 points.")],
)
def test_nothing_found_is_said(cycles, sentence):
    points = table(cycles=cycles, threads=list(range(len(cycles))))
    assert finding(points, ["threads"], "cycles") == sentence


def test_failed_points_are_on_no_front():
    points = BY_HAND.copy()
    points.loc[0, "status"] = "failed"

    assert pareto_front(points, ["cycles"])["cycles"].tolist() == [20]


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=12))
def test_the_front_is_what_nothing_beats(rows):
    points = table(a=[a for a, _ in rows], b=[b for _, b in rows])

    found = {tuple(row) for row in pareto_front(points, ["a", "b"])[["a", "b"]].to_numpy().tolist()}

    assert found == {
        (a, b) for a, b in rows if not any(c <= a and d <= b and (c, d) != (a, b) for c, d in rows)
    }


def test_the_parameter_that_moves_the_metric_comes_first():
    found = sensitivity(BY_HAND, ["threads", "size"], "cycles")

    assert found["parameter"].tolist() == ["size", "threads"]
    assert found["range_percent"].tolist() == [pytest.approx(100 * 90 / 40), pytest.approx(100 * 50 / 40)]
    assert found["best"].tolist() == ["4 KiB", "1"]
    values = np.array([10, 100, 20, 30])
    means = np.array([10, 100, 25, 25])
    assert found["explained_percent"][0] == pytest.approx(100 * means.var() / values.var())


def test_quantities_are_compared_by_their_amount():
    assert amounts(BY_HAND, "size").tolist() == [4096, 1024, 2048, 2048]
    with pytest.raises(ArchsimError, match="did you mean 'cycles'"):
        amounts(BY_HAND, "cycle")
    with pytest.raises(ArchsimError, match="cannot be compared"):
        amounts(table(order=["block"]), "order")


def test_nothing_finished_is_no_error():
    points = BY_HAND.assign(status="failed")

    assert len(pareto_front(points, ["cycles"])) == 0
    assert knee(pareto_front(points, ["cycles"]), ["cycles"]) is None
    assert len(pareto_front(points, [])) == 0
    assert sensitivity(points, ["threads"], "cycles")["range_percent"].tolist() == [0]


def test_values_are_in_the_order_of_their_amounts():
    points = table(size=["4 KiB", "512 B", None, "1 KiB"], order=["b", "a", None, "b"])

    assert in_order(points, "size") == [AS_IN_THE_RUN, "512 B", "1 KiB", "4 KiB"]
    assert in_order(points, "order") == ["b", "a", AS_IN_THE_RUN]


def test_points_without_the_metric_say_nothing_about_it():
    points = table(cycles=[10, np.nan, 30], threads=[1, 1, 2])

    assert sensitivity(points, ["threads"], "cycles")["range_percent"].tolist() == [100]
    assert finding(points, ["threads"], "cycles").startswith("cycles is least, 10, with threads 1")
