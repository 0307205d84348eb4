"""Every constraint of the data sheet moves the finish by exactly itself, and requests are served in the right order.

One tick is a core cycle and a memory clock; a request reaches the DRAM one cycle after its LOAD issues.
"""

import pytest

from archsim.model.dram.spec import AddressField, Scheduler
from tests.machine.build import (
    CACHE,
    CLOSED_BANK,
    CORE,
    DRAM,
    MACHINE,
    TIMING,
    address,
    both_models,
    load,
    machine,
    store,
    work,
)

pytestmark = both_models

ROW0, ROW0_NEXT, ROW0_LAST = (address(column=column) for column in (0, 2, 4))
ROW1, ROW2 = address(row=1), address(row=2)
BANK1 = address(bank=1)

ONE_LINE = CACHE._replace(num_sets=1, num_ways=1)  # a STORE is written back by the next miss


def timed(num_threads=1, cache=CACHE, dram=DRAM, **timing):
    spec = machine(num_threads=num_threads, caches=(cache,))
    within = {f"{name}_l": timing[name] for name in ("n_rrd", "n_ccd", "n_wtr") if name in timing}
    return spec._replace(dram=dram._replace(timing=TIMING._replace(**{**within, **timing})))


IN_ORDER = DRAM._replace(scheduler=Scheduler.FCFS)
WRITES = {"cache": ONE_LINE, "dram": IN_ORDER}

# (parameter, the machine, the tasks, the cycle of the finish)
CONSTRAINTS = [
    # ACT 1, RD 14, here at 14 + 11 + 1
    ("n_cl", {}, [[load(ROW0)]], 26),
    ("n_rcd_read", {}, [[load(ROW0)]], 26),
    # arrives at 127: PRE 127, ACT 144, RD 157
    ("n_rp", {}, [[load(ROW0), 100, load(ROW1)]], 169),
    # ACT 1, so PRE 102, ACT 119, RD 132
    ("n_ras", {"n_ras": 101}, [[load(ROW0), load(ROW1)]], 144),
    # ACT 1, so ACT 152, RD 165
    ("n_rc", {"n_rc": 151}, [[load(ROW0), load(ROW1)]], 177),
    # RD 14, so PRE 75, ACT 92, RD 105
    ("n_rtp", {"n_rtp": 61}, [[load(ROW0), load(ROW1)]], 117),
    # ACT 1, so ACT 30, RD 43
    ("n_rrd", {"num_threads": 2, "n_rrd": 29}, [[load(ROW0)], [load(BANK1)]], 55),
    # RD 14, so RD 33
    ("n_ccd", {"num_threads": 2, "n_ccd": 19}, [[load(ROW0)], [load(ROW0_NEXT)]], 45),
    # RD 14; RD 27 of the next line, its victim WR 27 + 41 = 68; RD 68 + 5 + 1 + 37 = 111
    ("n_rtw", WRITES, [[store(ROW0), load(ROW0_NEXT), load(ROW0_LAST)]], 123),
    ("n_wl", WRITES, [[store(ROW0), load(ROW0_NEXT), load(ROW0_LAST)]], 123),
    ("n_wtr", WRITES, [[store(ROW0), load(ROW0_NEXT), load(ROW0_LAST)]], 123),
    # WR 68, so PRE 68 + 5 + 1 + 31 = 105, ACT 122, RD 135
    ("n_wr", WRITES, [[store(ROW0), load(ROW0_NEXT), load(ROW1)]], 147),
    # RD 57 of row 1; PRE 63, ACT 80, WR 139; RD 139 + 5 + 1 + 37 = 182
    ("n_rcd_write", {**WRITES, "n_rcd_write": 59}, [[store(ROW0), load(ROW1), load(ROW0_LAST)]], 194),
    # REF 211, so ACT 254, RD 267
    ("n_rfc", {"n_refi": 211}, [[214, load(ROW0)]], 279),
    ("n_refi", {"n_refi": 211}, [[214, load(ROW0)]], 279),
]


@pytest.mark.parametrize("more", [0, 1, 3])
@pytest.mark.parametrize(
    ("parameter", "spec", "steps", "cycles"), CONSTRAINTS, ids=[case[0] for case in CONSTRAINTS]
)
def test_every_constraint_moves_the_finish_by_itself(simulate, parameter, spec, steps, cycles, more):
    longer = spec.get(parameter, getattr(TIMING, parameter)) + more
    counters = simulate(timed(**{**spec, parameter: longer}), work(*steps))

    assert counters.cycles == cycles + more


def test_a_read_of_a_closed_bank(simulate):
    counters = simulate(MACHINE, work([load(ROW0)]))

    assert counters.cache_fetch_ticks.tolist() == [TIMING.n_rcd_read + TIMING.n_cl + 1]
    assert counters.dram_row_misses.tolist() == [1]
    assert counters.dram_activates.tolist() == [1]
    assert counters.dram_reads.tolist() == [1]
    assert counters.dram_data_clocks.tolist() == [1]


def test_a_read_of_an_open_row(simulate):
    counters = simulate(MACHINE, work([load(ROW0), 50, load(ROW0_NEXT)]))

    assert counters.cache_fetch_ticks[0] - CLOSED_BANK == TIMING.n_cl + 1
    assert counters.dram_row_hits.tolist() == [1]


def test_a_read_of_another_row(simulate):
    counters = simulate(MACHINE, work([load(ROW0), 50, load(ROW1)]))

    assert counters.cache_fetch_ticks[0] - CLOSED_BANK == TIMING.n_rp + CLOSED_BANK
    assert counters.dram_row_conflicts.tolist() == [1]
    assert counters.dram_precharges.tolist() == [1]


@pytest.mark.parametrize(("n_ccd", "cycles"), [(2, 131), (3, 135)])
def test_constraints_count_from_the_last_burst_of_a_line(simulate, n_ccd, cycles):
    """Two bursts: RD 14, 16; RD 29, 31; WR 31 + 41 = 72, 74; RD 74 + 43 = 117, 119; here at 119 + 12."""
    wide = ONE_LINE._replace(line_bytes=16)
    spec = timed(cache=wide, dram=IN_ORDER, n_ccd=n_ccd)
    counters = simulate(spec, work([store(ROW0), load(ROW0_NEXT), load(ROW0_LAST)]))

    assert counters.cycles == cycles
    assert counters.dram_data_clocks.tolist() == [2 * (3 + 1)]


@pytest.mark.parametrize(("n_ccd", "cycles"), [(2, 526), (3, 527)])
def test_a_write_follows_a_write_at_n_ccd(simulate, n_ccd, cycles):
    """RD 426 and 428 evict two dirty lines: WR 428 + 41 = 469 and 471; RD (here since 479) 471 + 43 = 514.

    With one clock more the first read is one earlier, since its thread had more slots; all after 428 stays.
    """
    two_lines = CACHE._replace(num_sets=1, num_ways=2)
    spec = timed(num_threads=2, cache=two_lines, n_ccd=n_ccd)
    first = [store(ROW0), 200, load(ROW0_LAST), 40, load(ROW0)]
    second = [store(ROW0_NEXT), 200, load(address(column=6))]
    counters = simulate(spec, work(first, second))

    assert counters.cycles == cycles


def test_the_bursts_of_a_line_need_the_command_bus(simulate):
    """Line of two bursts, RD 14 and 20: an ACT that may come at 20 comes at 21; at 19 it does not matter."""
    wide = CACHE._replace(line_bytes=16)
    cycles = [
        simulate(
            timed(num_threads=2, cache=wide, n_ccd=6, n_rrd=n_rrd), work([load(ROW0)], [load(BANK1)])
        ).cycles
        for n_rrd in (18, 19, 20)
    ]

    assert cycles == [50, 52, 52]


def test_longer_bursts_take_longer(simulate):
    """Eight beats: the last half a clock before 4 clocks after the first."""
    burst = DRAM._replace(burst_beats=8, beat_bytes=1)

    assert simulate(timed(dram=burst), work([load(ROW0)])).cycles == 1 + 13 + 11 + 4


def test_data_written_ends_with_the_burst(simulate):
    """WR 68 + 0, eight beats: RD 68 + 3 + 5 + 4 + 37 (the first fill is 3 later, so is everything else)."""
    burst = IN_ORDER._replace(burst_beats=8, beat_bytes=1)
    spec = timed(cache=ONE_LINE, dram=burst, n_ccd=4)
    counters = simulate(spec, work([store(ROW0), load(ROW0_NEXT), load(ROW0_LAST)]))

    assert counters.cycles == (68 + 3) + 5 + 4 + 37 + 11 + 4


@pytest.mark.parametrize(
    ("core_ticks", "dram_ticks", "cycles"),
    [
        (1, 3, 77),  # arrives at tick 1, so ACT 1, RD 14; last beat at 25.5 x 3 = 76.5
        (7, 3, 12),  # arrives at tick 7, so ACT 3, RD 16; last beat at 27.5 x 3 = 82.5, edge 84
        (3, 2, 18),  # arrives at tick 3, so ACT 2, RD 15; last beat at 26.5 x 2 = 53, edge 54
        (2, 4, 51),  # arrives at tick 2, so ACT 1, RD 14; last beat at 25.5 x 4 = 102, edge 102
    ],
)
def test_data_is_used_at_the_first_core_edge_after_its_last_beat(simulate, core_ticks, dram_ticks, cycles):
    spec = MACHINE._replace(
        core=CORE._replace(period_ticks=core_ticks), dram=DRAM._replace(period_ticks=dram_ticks)
    )

    assert simulate(spec, work([load(ROW0)])).cycles == cycles


@pytest.mark.parametrize(
    ("scheduler", "cycles", "activates"),
    [
        (Scheduler.FR_FCFS, 62, 2),  # RD 14, 16 (row 0), PRE 20, ACT 37, RD 50
        (Scheduler.FCFS, 98, 3),  # RD 14, PRE 20, ACT 37, RD 50, PRE 56, ACT 73, RD 86
    ],
    ids=["FR_FCFS", "FCFS"],
)
def test_an_open_row_is_served_first(simulate, scheduler, cycles, activates):
    spec = timed(num_threads=3, dram=DRAM._replace(scheduler=scheduler))
    counters = simulate(spec, work([load(ROW0)], [load(ROW1)], [load(ROW0_NEXT)]))

    assert counters.cycles == cycles
    assert counters.dram_activates.tolist() == [activates]


@pytest.mark.parametrize(("max_wait_clocks", "cycles"), [(12, 98), (13, 98), (14, 62), (15, 62)])
def test_who_waited_too_long_is_served_before_all_others(simulate, max_wait_clocks, cycles):
    """Row 1 arrived in clock 2; the other request of row 0 could be read in clock 16, after 14 clocks."""
    spec = timed(num_threads=3, dram=DRAM._replace(max_wait_clocks=max_wait_clocks))
    counters = simulate(spec, work([load(ROW0)], [load(ROW1)], [load(ROW0_NEXT)]))

    assert counters.cycles == cycles


@pytest.mark.parametrize(("num_queue_entries", "cycles"), [(1, 134), (2, 134), (3, 98), (4, 98)])
def test_the_scheduler_sees_the_oldest_only(simulate, num_queue_entries, cycles):
    """When the first has gone, the request of row 0 is the third."""
    spec = timed(num_threads=4, dram=DRAM._replace(num_queue_entries=num_queue_entries))
    counters = simulate(spec, work([load(ROW0)], [load(ROW1)], [load(ROW2)], [load(ROW0_NEXT)]))

    assert counters.cycles == cycles


def test_a_request_is_classified_when_it_enters_the_window(simulate):
    """Row 0's second request arrives while row 0 is open, but is first seen when row 1 is."""
    steps = [[load(ROW0)], [load(ROW1)], [load(ROW0_NEXT)]]
    narrow = simulate(timed(num_threads=3, dram=DRAM._replace(num_queue_entries=1)), work(*steps))
    wide = simulate(timed(num_threads=3), work(*steps))

    # Row 1 and row 0 again are seen when another row is open; or both are seen in clock 2 and 3, row 0 being open.
    assert (narrow.dram_row_misses[0], narrow.dram_row_conflicts[0], narrow.dram_row_hits[0]) == (1, 2, 0)
    assert (wide.dram_row_misses[0], wide.dram_row_conflicts[0], wide.dram_row_hits[0]) == (1, 1, 1)


@pytest.mark.parametrize(("scheduler", "cycles"), [(Scheduler.FR_FCFS, 29), (Scheduler.FCFS, 40)])
def test_banks_are_prepared_ahead(simulate, scheduler, cycles):
    """ACT 1 and 4, RD 14 and 17; in order ACT 1, RD 14, ACT 15, RD 28."""
    spec = timed(num_threads=2, dram=DRAM._replace(scheduler=scheduler))

    assert simulate(spec, work([load(ROW0)], [load(BANK1)])).cycles == cycles


def test_the_oldest_of_a_bank_decides_its_row(simulate):
    """Rows 1 and 2 of bank 0 wait while row 0 is served: row 1, the older, is opened next, then row 2."""
    counters = simulate(timed(num_threads=3), work([load(ROW0)], [load(ROW1), 1], [load(ROW2), 200]))

    assert counters.cycles == 98 + 200


def test_a_row_that_is_wanted_stays_open(simulate):
    """Bank 0 could be closed for row 1 at 20, but row 0 is wanted by the RD at 33: PRE 37, ACT 54, RD 67."""
    steps = [[load(ROW0)], [load(ROW1)], [load(ROW0_NEXT)]]
    counters = simulate(timed(num_threads=3, n_ccd=19), work(*steps))

    assert counters.cycles == 79
    assert counters.dram_activates.tolist() == [2]


def test_channels_work_side_by_side(simulate):
    two = DRAM._replace(num_channels=2, channel=AddressField(shift=3, bits=1))
    counters = simulate(timed(num_threads=2, dram=two), work([load(0)], [load(8)]))

    assert counters.cycles == 2 + CLOSED_BANK
    assert counters.dram_reads.tolist() == [1, 1]
    assert counters.dram_row_misses.tolist() == [1, 1]


def test_a_refresh_closes_the_open_banks_first(simulate):
    """PRE 211, REF 228, so ACT 271, RD 284. The LOAD arrives at 212 and finds the bank closed."""
    counters = simulate(timed(n_refi=211), work([load(ROW0), 185, load(ROW0_NEXT)]))

    assert counters.cycles == 284 + 12
    assert (counters.dram_precharges[0], counters.dram_refreshes[0], counters.dram_activates[0]) == (1, 1, 2)
    assert (counters.dram_row_misses[0], counters.dram_row_hits[0]) == (2, 0)


def test_a_request_is_classified_before_the_refresh_of_the_same_clock(simulate):
    counters = simulate(timed(n_refi=211), work([load(ROW0), 184, load(ROW0_NEXT)]))

    assert counters.cycles == 284 + 12
    assert (counters.dram_row_misses[0], counters.dram_row_hits[0]) == (1, 1)


def test_a_due_refresh_holds_everything_else_back(simulate):
    """Due at 211, while bank 0, opened at 205, cannot be closed before 224: the RD at 218 may not issue.

    PRE 224, REF 241, so ACT 284, RD 297.
    """
    counters = simulate(timed(n_refi=211), work([204, load(ROW0)]))

    assert counters.cycles == 297 + 12
    assert counters.dram_activates.tolist() == [2]


@pytest.mark.parametrize(("cycles", "refreshes"), [(499, 9), (500, 10), (549, 10)])
def test_refreshes_come_without_requests_until_the_end(simulate, cycles, refreshes):
    counters = simulate(timed(n_refi=50), work([cycles]))

    assert counters.dram_refreshes.tolist() == [refreshes]


def test_a_late_refresh_does_not_move_the_next(simulate):
    """The first is 17 late (a bank had to be closed), the second comes at 2 x 211."""
    spec = timed(n_refi=211)
    counters = simulate(spec, work([load(ROW0), 395]))

    assert counters.cycles == 421
    assert counters.dram_refreshes.tolist() == [1]
    assert simulate(spec, work([load(ROW0), 396])).dram_refreshes.tolist() == [2]
