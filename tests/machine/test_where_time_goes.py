"""Every stalled slot has one cause: each of them by hand, on both models.

One tick is a core cycle and a memory clock, hits take one cycle. A LOAD that misses is looked up for one slot; the row
of a closed bank takes n_rcd_read = 13 slots, the data n_cl + 1 = 12, in the last of which the thread issues again.
"""

import pytest

from archsim.machine.counters import STALL_MEMORY
from tests.machine.build import (
    CACHE,
    DRAM,
    TIMING,
    address,
    both_models,
    cached,
    load,
    machine,
    stalls,
    store,
    work,
)

pytestmark = both_models

A, B = address(), address(column=2)
FETCH = {"0.lookup": 1, "dram.activation": 13, "dram.bus": 11}


def test_a_miss_waits_for_its_lookup_its_row_and_its_data(simulate):
    assert stalls(simulate(machine(), work([load(A), 1]))) == FETCH


def test_a_thread_waits_for_a_port(simulate):
    """Core 1 merges in cycle 1, and hits in cycle 37 instead of 36."""
    steps = [load(A), 10, load(A), 1]
    counters = simulate(machine(num_cores=2, caches=(CACHE._replace(num_ports=1),)), work(steps, steps))

    assert stalls(counters, 0) == {**FETCH, "no_work": 1}
    assert stalls(counters, 1) == {"0.port": 1 + 1, "dram.activation": 13, "dram.bus": 11}


@pytest.mark.parametrize(
    ("cache", "cause"),
    [(CACHE._replace(num_mshrs=1), "0.mshr"), (CACHE._replace(num_sets=1, num_ways=1), "0.way")],
)
def test_a_miss_waits_for_what_it_lacks(simulate, cache, cause):
    """B, asked for in slot 1, is accepted in cycle 26, when A has come."""
    counters = simulate(machine(num_threads=2, caches=(cache,)), work([load(A)], [load(B), 1]))

    assert stalls(counters) == {cause: 25, "0.lookup": 1, "dram.bus": 11}


def test_a_merge_waits_for_a_target(simulate):
    spec = machine(num_threads=3, caches=(CACHE._replace(num_targets=2),))
    counters = simulate(spec, work([load(A)], [load(A)], [load(A), 1]))

    assert stalls(counters) == {"0.target": 24}


def test_a_write_waits_for_room(simulate):
    """The write of slot 0 is at the DRAM in cycle 5; the next one, of slot 1, is accepted then."""
    cache = CACHE._replace(allocates_writes=0, num_write_entries=1, hit_cycles=5)
    counters = simulate(machine(num_threads=2, caches=(cache,)), work([store(A)], [store(B), 1]))

    assert stalls(counters) == {"0.write_queue": 4, "0.lookup": 4}


def test_who_stands_behind_a_refused_request_waits_for_the_same(simulate):
    """Thread 2 stands behind B until cycle 26, in which the port is B's."""
    spec = machine(num_threads=3, caches=(CACHE._replace(num_mshrs=1, num_ports=1),))
    counters = simulate(spec, work([load(A)], [load(B)], [load(A), 1]))

    assert stalls(counters) == {"0.mshr": 24, "0.port": 1, "no_work": 39 - 29}


def test_a_fetch_waits_at_the_next_level(simulate):
    """Core 1's fetch comes to the L2 with core 0's, in cycle 1; the only MSHR is free in cycle 27."""
    caches = (CACHE._replace(parent=2), CACHE._replace(parent=2), CACHE._replace(num_mshrs=1))
    spec = machine(num_cores=2, caches=caches)._replace(core_cache=(0, 1))
    counters = simulate(spec, work([load(A), 1], [load(B), 1]))

    assert stalls(counters, 1) == {"1.lookup": 1, "2.mshr": 26, "2.lookup": 1, "dram.bus": 11}


def test_a_read_waits_for_others_and_for_its_row(simulate):
    """The bank is open from 1 on for n_ras; then the second row needs n_rp and n_rcd_read."""
    counters = simulate(machine(num_threads=2), work([load(A)], [load(address(row=1)), 1]))

    queue = (1 + TIMING.n_ras) - 2
    assert stalls(counters) == {
        "0.lookup": 1,
        "dram.queue": queue,
        "dram.activation": 17 + 13,
        "dram.bus": 11,
    }


def test_a_read_waits_for_a_refresh(simulate):
    """REF in 211; the read comes in 214."""
    dram = DRAM._replace(timing=TIMING._replace(n_refi=211))
    counters = simulate(machine(dram=dram), work([213, load(A), 1]))

    assert stalls(counters) == {**FETCH, "dram.refresh": TIMING.n_rfc - 3}


def test_a_read_waits_for_the_bus_to_turn(simulate):
    """WR in 8, its data until 14, in which the row can be read, too; the read comes in 10."""
    spec = cached(CACHE._replace(allocates_writes=0))
    counters = simulate(spec, work([store(A), 8, load(B), 1]))

    wanted = {"0.lookup": 1, "dram.activation": 4, "dram.turnaround": TIMING.n_wtr, "dram.bus": 11}
    assert stalls(counters) == wanted


def test_a_wait_is_charged_only_where_no_other_thread_issues(simulate):
    """The first 20 slots of the wait are used by the other thread."""
    counters = simulate(machine(num_threads=2), work([load(A), 1], [20]))

    assert stalls(counters) == {"dram.bus": 5}


def test_clocks_that_do_not_divide(simulate):
    """A cycle is 7 ticks, a clock 12: the ACT is in clock 1, tick 12; the RD in clock 14, tick 168, that of cycle 24.

    The data is here at tick 12 * 25.5 = 306, in time for cycle 44. The slot of cycle 1, tick 7, comes before clock 1.
    """
    spec = machine(dram=DRAM._replace(period_ticks=12))
    counters = simulate(spec._replace(core=spec.core._replace(period_ticks=7)), work([load(A), 1]))

    wanted = {"0.lookup": 1, "dram.activation": 24 - 1, "dram.bus": 43 - 24}
    assert stalls(counters) == wanted
    assert counters.stalled[:, STALL_MEMORY:].sum() == counters.stalled.sum() == 43
