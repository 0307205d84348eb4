"""A delay stream between two units: release, room, overflow, traffic."""

import pytest

from archsim.errors import DeadlockError
from archsim.model.delay_stream.spec import Overflow
from archsim.model.unit.spec import Slot
from tests.machine.build import DRAM
from tests.machine.pipeline.build import STREAM, UNIT, both_models, delayed, emit, mark, take, work

pytestmark = both_models

WRITTEN = (
    7 + 5 + 1
)  # ACT to WR, WR to its data, the data's last beat: a write sent at T is answered at T + 13


def test_an_item_is_written_and_read_before_it_can_be_taken(simulate):
    """Emitted at 0, in at 1, MARK at 1; at 2 it is sent, at 2 + 13 asked for.

    The read waits for n_wtr behind the write's data, then takes n_cl and its last beat; it is taken a cycle later.
    """
    counters = simulate(delayed(UNIT, UNIT), work([[emit(0, 5), mark()]], [[take()]]))

    written = 2 + WRITTEN
    read = written + 37
    assert counters.cycles == read + 11 + 1 + 1 + 1
    assert (counters.stream_bytes[0], counters.stream_writes[0], counters.stream_reads[0]) == (5, 1, 1)
    assert counters.channel_stayed.tolist() == [5 * (read + 13 - 1)]


def test_nothing_passes_before_the_mark(simulate):
    """The first item is complete in memory long before; its reading begins when the MARK has been seen, at 202."""
    counters = simulate(delayed(UNIT, UNIT), work([[emit(0, 8), 200, mark()]], [[take()]]))

    assert counters.cycles == 202 + 11 + 1 + 1 + 1
    assert counters.stream_marks.tolist() == [1]


def test_a_stream_is_written_and_read_in_lines(simulate):
    """5 items of 5 bytes: three full lines, and the byte that the MARK releases."""
    items = [[emit(0, 5)]] * 4 + [[emit(0, 5), mark()]]
    counters = simulate(delayed(UNIT, UNIT), work(items, [[take()]] * 5))

    assert (counters.stream_writes[0], counters.stream_reads[0]) == (4, 4)
    assert counters.channel_peak.tolist() == [25]
    assert counters.memory.dram_data_clocks.tolist() == [8]


def test_a_full_ring_holds_its_producer_back(simulate):
    """64 bytes hold four items of 16; the other four wait until the first are taken."""
    groups = [[emit(0, 16), mark()]] * 8
    counters = simulate(
        delayed(UNIT._replace(in_flight=1), UNIT._replace(interval_cycles=100)), work(groups, [[take()]] * 8)
    )

    assert counters.channel_peak.tolist() == [64]
    assert counters.unit_slots[0, Slot.DELAY_STREAM] > 100
    assert counters.stream_early.tolist() == [0]


def test_items_that_fill_the_ring_without_a_mark_come_early(simulate):
    """10 items of 10 bytes in 64: those that begin more than 64 bytes before the end, at 0, 10, 20 and 30."""
    items = [[emit(0, 10)]] * 9 + [[emit(0, 10), mark()]]
    stream = STREAM._replace(overflow=Overflow.RELEASE)
    counters = simulate(delayed(UNIT, UNIT, stream), work(items, [[take()]] * 10))

    assert counters.stream_early.tolist() == [4]
    assert counters.channel_taken.tolist() == [10]


def test_or_wait_for_ever(simulate):
    items = [[emit(0, 10)]] * 9 + [[emit(0, 10), mark()]]

    with pytest.raises(DeadlockError) as error:
        simulate(delayed(UNIT, UNIT), work(items, [[take()]] * 10))
    assert "a waits for room for an item to b through a delay stream" in str(error.value)
    assert "b waits for an item from a through a delay stream" in str(error.value)


def test_what_overflows_depends_on_sizes_only(simulate):
    """The same items come early however slow the consumer is."""
    items = [[emit(0, size)] for size in (3, 17, 20, 5, 20, 9, 20, 11, 20)] + [[emit(0, 1), mark()]]
    stream = STREAM._replace(overflow=Overflow.RELEASE)
    early = {
        int(
            simulate(
                delayed(UNIT, UNIT._replace(interval_cycles=n), stream), work(items, [[take()]] * 10)
            ).stream_early[0]
        )
        for n in (1, 30, 500)
    }

    assert early == {5}  # of 126 bytes those that begin before byte 62: at 0, 3, 20, 40, 45


def test_writes_are_answered_at_their_last_beat(simulate):
    """One write under way at a time: two lines are written WRITTEN cycles, then 5 + 1 cycles apart."""
    stream = STREAM._replace(outstanding=1)
    one = simulate(delayed(UNIT, UNIT, stream), work([[emit(0, 8), mark()]], [[take()]]))
    two = simulate(delayed(UNIT, UNIT, stream), work([[emit(0, 16), mark()]], [[take()]]))

    assert DRAM.timing.n_wl + 1 == 6
    assert (one.stream_writes[0], two.stream_writes[0]) == (1, 2)
    assert two.cycles > one.cycles
