"""Advice in words: each limit on its own, and none where none is clear."""

import pytest

from archsim.report.advice import advice
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
