"""Advice in words: each limit on its own, and none where none is clear."""

import pytest

from archsim.report.advice import advice, pipeline_advice
from archsim.report.statistics import Phase

QUIET = {
    "cycles": 1000,
    "useful_percent": 60.0,
    "stall.no_work_percent": 10.0,
    "stall.lock_percent": 10.0,
    "stall.l1_percent": 5.0,
    "stall.l2_percent": 5.0,
    "stall.dram_percent": 10.0,
    "l1.port_percent": 30.0,
    "l2.port_percent": 30.0,
    "l1.blocked_cycles": 10,
    "l2.blocked_cycles": 10,
    "dram.bus_percent": 40.0,
    "dram.row_hits": 60,
    "dram.row_misses": 0,
    "dram.row_conflicts": 40,
}


def said(**changes) -> list[str]:
    values = {**QUIET, **{name.replace("__", "."): value for name, value in changes.items()}}
    return advice(Phase("p", values, ["l1", "l2"]))


def test_no_clear_limit_is_said_to_be_none():
    assert said(stall__lock_percent=14.0) == [
        "No single limit is clear; most empty slots, 14 %, wait for a lock."
    ]


@pytest.mark.parametrize(
    ("changes", "start"),
    [
        ({"useful_percent": 85.0}, "Limited by issue: 85 %"),
        ({"dram__bus_percent": 91.0}, "Limited by DRAM bandwidth: the data buses are busy 91 %"),
        ({"l2__port_percent": 95.0}, "Limited by the ports of l2: 95 %"),
        ({"stall__dram_percent": 30.0}, "Limited by DRAM latency: 30 % of the slots"),
        ({"l1__blocked_cycles": 300}, "l1 turned requests away in 30 % of the cycles"),
        ({"stall__lock_percent": 20.0}, "20 % of the slots wait for locks"),
        ({"stall__no_work_percent": 20.0}, "20 % of the slots have no work"),
        ({"stall__l2_percent": 20.0}, "20 % of the slots wait for l2"),
    ],
)
def test_each_limit_is_named_with_its_number(changes, start):
    (sentence,) = said(**changes)

    assert sentence.startswith(start)


def test_waiting_for_a_full_bus_is_bandwidth_not_latency():
    (sentence,) = said(stall__dram_percent=50.0, dram__bus_percent=95.0)

    assert sentence.startswith("Limited by DRAM bandwidth")


def test_many_row_conflicts_are_mentioned():
    assert (
        "70 % of the requests meet another open row"
        in said(stall__dram_percent=30.0, dram__row_hits=30, dram__row_conflicts=70)[0]
    )


FLOW = {"cycles": 1000, "a.busy_percent": 60.0, "b.busy_percent": 10.0, "dram.bus_percent": 40.0}
WAITS = {"a": {"no_work": 5.0, "pool": 30.0, "l2.mshr": 5.0}, "b": {"output": 90.0}}


def said_of_units(**changes) -> list[str]:
    values = {**FLOW, **{name.replace("__", "."): value for name, value in changes.items()}}
    return pipeline_advice(Phase("p", values, [], ("a", "b")), WAITS)


def test_of_a_pipeline_the_busiest_unit_is_said_and_what_it_waits_for():
    assert said_of_units() == [
        "a is the busiest unit, with 60 % of the cycles; in 30 % it waits for a free buffer."
    ]


def test_a_unit_near_its_peak_is_the_limit():
    (sentence,) = said_of_units(a__busy_percent=92.0)
    assert sentence.startswith("Limited by a: it is busy in 92 % of the cycles.")


def test_a_pipeline_can_be_limited_by_the_dram_too():
    assert said_of_units(dram__bus_percent=95.0)[0].startswith("Limited by DRAM bandwidth")
