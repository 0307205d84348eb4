"""Which commands a channel issues in which clocks, computed by hand, for whatever a single machine cannot show well.

A request is `(clock, address)`, a write with a third item; it is one burst of one clock, 8 bytes.
"""

import numpy as np
import pytest

from archsim.machine.dram_alone import compiled, reference
from archsim.machine.dram_alone.stream import Requests
from archsim.model.dram.commands import COMMAND, Command
from archsim.model.dram.spec import AddressField, PagePolicy, Scheduler
from tests.machine.build import DRAM, TIMING

both_models = pytest.mark.parametrize("model", [reference, compiled], ids=["reference", "compiled"])
pytestmark = both_models

WRITE = True


def at(bank=0, row=0, column=0):
    return row << 9 | bank << 7 | column * 8


def served(model, spec, *requests):
    """The run, and its commands as `clock NAME bank`."""
    arrivals, addresses, writes = zip(*((r[0], r[1], len(r) > 2) for r in requests), strict=True)
    stream = Requests(np.array(addresses), np.array(writes), np.array(arrivals))
    recorded = [np.zeros(0, COMMAND)]
    size = spec.burst_beats * spec.beat_bytes
    run = model.simulate(spec, size, [stream], recorded.append)
    listed = np.sort(np.concatenate(recorded), order=["clock", "channel"])
    return run, [f"{each['clock']} {Command(each['command']).name} {each['bank']}" for each in listed]


def commands(model, spec, *requests):
    return served(model, spec, *requests)[1]


def timed(**timing):
    return DRAM._replace(timing=TIMING._replace(**timing))


# Banks 0 and 2 are group 0, banks 1 and 3 group 1.
GROUPED = DRAM._replace(
    num_groups=2,
    group=AddressField(7, 1),
    bank=AddressField(8, 1),
    timing=TIMING._replace(n_rrd_l=5, n_ccd_l=29, n_wtr_l=61),
)


@pytest.mark.parametrize(("bank", "act"), [(1, 3), (2, 5)])
def test_n_rrd_l_holds_within_a_group(model, bank, act):
    issued = commands(model, GROUPED, (0, at(0)), (0, at(bank)))
    assert issued[:2] == ["0 ACT 0", f"{act} ACT {bank}"]


@pytest.mark.parametrize(("bank", "read"), [(1, 16), (2, 13 + 29), (0, 13 + 29)])
def test_n_ccd_l_holds_within_a_group(model, bank, read):
    """RD of bank 0 in 13; that of bank 1 when its n_rcd_read is over, in 3 + 13."""
    issued = commands(model, GROUPED, (0, at(0)), (0, at(bank, column=1)))
    assert issued[-1] == f"{read} RD {bank}"


@pytest.mark.parametrize(("bank", "read"), [(1, 16 + 5 + 1 + 37), (2, 16 + 5 + 1 + 61)])
def test_n_wtr_l_holds_within_a_group(model, bank, read):
    """WR of bank 0 in 16, long after its ACT, so that nothing else holds the RD back."""
    spec = GROUPED._replace(timing=GROUPED.timing._replace(n_rcd_write=16, n_ccd_l=2))
    issued = commands(model, spec, (0, at(0), WRITE), (0, at(bank, column=1)))
    assert issued[-1] == f"{read} RD {bank}"


@pytest.mark.parametrize("more", [0, 1, 3])
def test_bursts_of_a_request_are_n_ccd_l_apart(model, more):
    """Requests of two bursts: last beat n_ccd_l later, and so is the next request's RD of another group."""
    spec = GROUPED._replace(beat_bytes=2, timing=GROUPED.timing._replace(n_ccd_l=6 + more, n_rrd=1))
    stream = Requests(np.array([at(0), at(1)]), np.zeros(2, bool), np.zeros(2, np.int64))
    recorded = []
    run = model.simulate(spec, 8, [stream], recorded.append)

    reads = [each for each in np.concatenate(recorded) if each["command"] == Command.RD]
    assert [(int(each["clock"]), int(each["bursts"])) for each in reads] == [(13, 2), (13 + 6 + more + 2, 2)]
    assert run.clocks == 13 + 2 * (6 + more) + 2 + 11 + 1


@pytest.mark.parametrize(("n_faw", "fifth"), [(0, 12), (12, 12), (13, 13), (20, 20)])
def test_the_fifth_act_waits_for_the_first(model, n_faw, fifth):
    """Eight banks: ACT in 0, 3, 6, 9; the fifth not before 12 (n_rrd) and n_faw, the sixth 3 + n_faw."""
    spec = timed(n_faw=n_faw, n_rcd_read=100)._replace(
        num_banks=8, bank=AddressField(7, 3), row=AddressField(10, 8)
    )
    issued = commands(model, spec, *((0, bank << 7) for bank in range(6)))

    assert issued[:5] == ["0 ACT 0", "3 ACT 1", "6 ACT 2", "9 ACT 3", f"{fifth} ACT 4"]
    assert issued[5] == f"{max(fifth + 3, 3 + n_faw)} ACT 5"


def test_an_open_page_stays_open(model):
    assert commands(model, DRAM, (0, at(0)), (500, at(0, 0, 1))) == ["0 ACT 0", "13 RD 0", "500 RD 0"]


def test_a_closed_page_is_closed_when_nobody_wants_it(model):
    """RD 13, so PRE 13 + n_rtp = 17, but not before 0 + n_ras = 19."""
    spec = DRAM._replace(page_policy=PagePolicy.CLOSED)
    issued = commands(model, spec, (0, at(0)), (500, at(0, 0, 1)))

    assert issued == ["0 ACT 0", "13 RD 0", "19 PRE 0", "500 ACT 0", "513 RD 0", "519 PRE 0"]


def test_a_closed_page_stays_open_for_who_waits(model):
    """The second RD in 15, so PRE in 19 still; the third request comes too late."""
    spec = DRAM._replace(page_policy=PagePolicy.CLOSED)
    issued = commands(model, spec, (0, at(0)), (2, at(0, 0, 1)), (19, at(0, 0, 2)))

    assert issued[:4] == ["0 ACT 0", "13 RD 0", "15 RD 0", "19 RD 0"]
    assert issued[4:] == ["23 PRE 0"]


@pytest.mark.parametrize(
    ("arrival", "issued"), [(73, ["73 RD 0"]), (74, ["73 PRE 0", "90 ACT 0", "103 RD 0"])]
)
def test_a_row_is_closed_when_its_time_is_out(model, arrival, issued):
    """RD 13, so the row is closed in 73, unless a request is there."""
    spec = DRAM._replace(page_policy=PagePolicy.TIMEOUT, page_timeout_clocks=60)
    assert commands(model, spec, (0, at(0)), (arrival, at(0, 0, 1)))[2:] == issued


def test_the_lowest_bank_is_closed_first(model):
    """RD 13 and 16; both could be closed in 60."""
    spec = DRAM._replace(page_policy=PagePolicy.CLOSED, timing=TIMING._replace(n_rtp=47, n_rrd=1))
    issued = commands(model, spec, (0, at(2)), (0, at(1)), (400, at(3)))

    assert issued[:6] == ["0 ACT 2", "1 ACT 1", "13 RD 2", "15 RD 1", "60 PRE 2", "62 PRE 1"]


QUEUED = DRAM._replace(num_write_entries=4, write_high=3, write_low=1)


def test_writes_wait_for_reads(model):
    """The read that comes last is served first; then no read waits, and the write is."""
    spec = QUEUED._replace(timing=TIMING._replace(n_rrd=1))
    issued = commands(model, spec, (0, at(0)), (1, at(1), WRITE), (2, at(2)))

    assert issued == ["0 ACT 0", "2 ACT 2", "13 RD 0", "15 RD 2", "16 ACT 1", f"{15 + 41} WR 1"]


def test_writes_are_drained_from_the_high_mark_to_the_low_one(model):
    """Three writes wait in clock 3: two of them go, although reads wait, then reads; the last when no read waits."""
    row = [at(0, 0, column) for column in range(8)]
    reads, writes = [(3, row[4]), (3, row[5])], [(1, row[1], WRITE), (2, row[2], WRITE), (3, row[3], WRITE)]
    issued = commands(model, QUEUED, (0, row[0]), *writes, *reads)

    kinds = [each.split()[1] for each in issued]
    assert kinds == ["ACT", "WR", "WR", "RD", "RD", "RD", "WR"]
    # ACT 0, WR 7 and 9; RD 9 + 5 + 1 + 37 = 52, 54, 56; WR 56 + 41
    assert [int(each.split()[0]) for each in issued] == [0, 7, 9, 52, 54, 56, 97]


def test_writes_below_the_high_mark_wait_while_reads_do(model):
    row = [at(0, 0, column) for column in range(8)]
    issued = commands(model, QUEUED, (0, row[0]), (0, row[1], WRITE), (0, row[2], WRITE), (9, row[3]))

    assert [each.split()[1] for each in issued] == ["ACT", "RD", "RD", "WR", "WR"]


def test_a_read_of_a_waiting_write_is_forwarded(model):
    """The write waits behind the read of clock 0, so the read of clock 5 is answered in 6."""
    run, issued = served(model, QUEUED, (0, at(0)), (1, at(1), WRITE), (5, at(1)))

    assert run.counters["forwarded"].tolist() == [1]
    assert run.latencies[1] == 1
    assert [each.split()[1] for each in issued] == ["ACT", "RD", "ACT", "WR"]
    assert (run.counters["row_misses"].tolist(), run.counters["row_hits"].tolist()) == ([2], [0])


@pytest.mark.parametrize(
    "requests",
    [
        [(0, at(0)), (1, at(1, 0, 1), WRITE), (5, at(1))],  # another line
        [(0, at(0)), (5, at(1)), (5, at(1), WRITE)],  # the write comes after the read
        [(0, at(1), WRITE), (40, at(1))],  # the write has gone
    ],
)
def test_other_reads_are_not_forwarded(model, requests):
    run, _ = served(model, QUEUED, *requests)
    assert run.counters["forwarded"].tolist() == [0]


def test_without_a_write_queue_nothing_is_forwarded(model):
    run, _ = served(model, DRAM, (0, at(0)), (1, at(1), WRITE), (5, at(1)))
    assert run.counters["forwarded"].tolist() == [0]


def test_rows_are_hashed_into_banks(model):
    """Row 1 of bank 0 and row 2 of bank 3 lie in bank 1: 0 ^ 1, 3 ^ 2."""
    spec = DRAM._replace(bank_hash=2)
    issued = commands(model, spec, (0, at(0, 1)), (100, at(3, 2)), (200, at(2, 4)))

    assert [each.split()[2] for each in issued if "ACT" in each] == ["1", "1", "2"]


def test_four_beats_a_clock(model):
    """Eight beats in two clocks: last beat 13 + 11 + 7/4; the RD after a WR 7 + 5 + 2 + 37."""
    spec = DRAM._replace(burst_beats=8, clock_beats=4, beat_bytes=1)
    run, _ = served(model, spec, (0, at(0)))
    assert run.clocks == run.latency_max == 13 + 11 + 2
    assert run.counters["data_clocks"].tolist() == [2]
    assert commands(model, spec, (0, at(0), WRITE), (0, at(0, 0, 1)))[-1] == "51 RD 0"


def test_an_ideal_dram_serves_all_at_once(model):
    spec = DRAM._replace(scheduler=Scheduler.IDEAL, timing=TIMING._replace(n_cl=9))
    run, issued = served(model, spec, *((5, at(bank, bank)) for bank in range(4)), (5, at(0), WRITE))

    assert issued == []
    assert run.latencies[9] == run.latencies.sum() == 4
    assert run.clocks == 5 + 9
    assert run.counters["row_hits"].tolist() == [5]


def test_requests_enter_when_there_is_room(model):
    """Two places: the third request enters when the first has gone, in clock 14, and waits for 10 until then."""
    spec = DRAM._replace(num_queue_entries=2)
    run, _ = served(model, spec, (0, at(0)), (4, at(0, 0, 1)), (4, at(0, 0, 2)))

    assert run.wait_sum == 14 - 4
    assert run.latencies[[25, 15 + 12 - 4, 17 + 12 - 14]].tolist() == [1, 1, 1]


def test_the_column_of_a_request_that_is_less_than_a_line_is_where_it_begins(model):
    """Lines of 32 bytes, that is four bursts; a request is one burst."""
    spec = DRAM._replace(line=AddressField(5, 2))
    recorded = [np.zeros(0, COMMAND)]
    stream = Requests(np.array([at(column=2), at(column=5)]), np.zeros(2, bool), np.zeros(2, np.int64))
    model.simulate(spec, spec.burst_beats * spec.beat_bytes, [stream], recorded.append)
    listed = np.concatenate(recorded)
    assert listed["column"][listed["command"] == Command.RD].tolist() == [2, 5]
