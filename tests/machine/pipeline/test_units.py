"""A unit of a pipeline: its pace, its latency, what it waits for, in cycles counted by hand."""

import pytest

from archsim.model.cache.spec import ClearSpec
from archsim.model.fifo.spec import FifoSpec
from archsim.model.pool.spec import PoolSpec
from archsim.model.unit.spec import Slot
from tests.machine.build import CACHE, CLOSED_BANK, OPEN_ROW
from tests.machine.pipeline.build import (
    UNIT,
    acquire,
    both_models,
    chain,
    clear,
    emit,
    load,
    machine,
    on_dram,
    release,
    store,
    take,
    work,
)

pytestmark = both_models


def slots(counters, unit):
    """The cycles of a unit's front by what it did, without the zeros."""
    return {Slot(k).name: int(n) for k, n in enumerate(counters.unit_slots[unit]) if n}


def test_a_task_occupies_the_interval(simulate):
    counters = simulate(machine(UNIT._replace(interval_cycles=7)), work([[], [], []]))

    assert counters.cycles == 3 * 7
    assert counters.unit_tasks.tolist() == [3]
    assert slots(counters, 0) == {"BUSY": 21}


def test_compute_takes_longer_than_the_interval(simulate):
    """ceil(11 / 4) and ceil(13 / 4) cycles, then the interval of the empty task."""
    unit = UNIT._replace(interval_cycles=2, lanes=4)

    assert simulate(machine(unit), work([[11], [13], []])).cycles == 3 + 4 + 2


def test_an_item_passes_after_the_latency(simulate):
    """Emitted at 0, put in at 5, taken at 6, put in at 6 + 3, taken at 10, whose task lasts a cycle."""
    a, b = UNIT._replace(latency_cycles=5), UNIT._replace(latency_cycles=3)
    counters = simulate(chain(a, b, UNIT), work([[emit()]], [[take(), emit()]], [[take()]]))

    assert counters.cycles == 5 + 1 + 3 + 1 + 1
    assert counters.channel_put.tolist() == counters.channel_taken.tolist() == [1, 1]
    assert counters.channel_stayed.tolist() == [1, 1]


def test_a_pipeline_without_hindrance_takes_an_item_every_interval(simulate):
    """The last of 20 items is emitted at 19 x 2 and passes two units and two fifos."""
    unit = UNIT._replace(interval_cycles=2, latency_cycles=5)
    counters = simulate(
        chain(unit, unit, unit), work([[emit()]] * 20, [[take(), emit()]] * 20, [[take()]] * 20)
    )

    assert counters.cycles == 19 * 2 + (5 + 1) * 2 + 2
    assert slots(counters, 1) == {"BUSY": 40, "NO_WORK": counters.cycles - 40}


def test_the_interval_begins_when_the_item_is_taken(simulate):
    """Taken at 2; the second item, there since 3, is taken when the interval of 10 is over."""
    slow = UNIT._replace(interval_cycles=10)

    assert simulate(chain(UNIT, slow), work([[emit()], [emit()]], [[take()], [take()]])).cycles == 2 + 10 + 10


def test_a_full_fifo_holds_its_producer_back(simulate):
    """Room for 2 and 3 in flight: of 10 items the consumer takes one every 20 cycles, the first at 2.

    At 5 items the producer stands still: 2 in the fifo, 3 in flight. The item taken at 22 makes room at 23.
    """
    first, second = UNIT._replace(in_flight=3), UNIT._replace(interval_cycles=20)
    counters = simulate(chain(first, second, fifo=FifoSpec(2)), work([[emit()]] * 10, [[take()]] * 10))

    assert counters.cycles == 2 + 10 * 20
    assert counters.channel_peak.tolist() == [2]
    assert slots(counters, 0)["OUTPUT"] == 4 * 20 - 5 + 2


def test_a_short_queue_of_operations_shows_as_latency(simulate):
    """Two operations in flight, each for 10 cycles: they join at 0 and 1, 10 and 11, 20 and 21."""
    unit = UNIT._replace(latency_cycles=10, in_flight=2)
    counters = simulate(chain(unit, UNIT), work([[emit()]] * 6, [[take()]] * 6))

    assert counters.cycles == 21 + 10 + 1 + 1
    assert slots(counters, 0)["LATENCY"] == 8 + 1 + 9 + 1


def test_a_load_delays_what_follows_but_not_the_next_task(simulate):
    """The loads of both tasks are asked for at 0 and 1 and here at 25 and 26; the items are taken a cycle later."""
    unit = on_dram(latency_cycles=3)
    counters = simulate(chain(unit, UNIT), work([[load(0), emit()], [load(8), emit()]], [[take()], [take()]]))

    assert counters.cycles == CLOSED_BANK + 2 + 1 + 1
    assert slots(counters, 0) == {"BUSY": 2, "NO_WORK": counters.cycles - 2}
    assert (counters.unit_loads[0], counters.unit_load_bytes[0]) == (2, 8)


def test_a_load_waits_for_a_free_access(simulate):
    """One access: the second line is asked for when the first is here."""
    counters = simulate(machine(on_dram(outstanding=1)), work([[load(0)], [load(8)]]))

    assert counters.cycles == CLOSED_BANK + OPEN_ROW
    assert slots(counters, 0) == {"BUSY": 1, "MEMORY": CLOSED_BANK - 1, "NO_WORK": OPEN_ROW}


def test_an_access_is_cut_at_lines(simulate):
    """Bytes 6 to 29 lie in four lines of 8 bytes."""
    counters = simulate(machine(on_dram()), work([[load(6, 24)]]))

    assert counters.unit_loads.tolist() == [4]
    assert counters.unit_load_bytes.tolist() == [24]
    assert counters.memory.dram_reads.tolist() == [4]


def test_a_request_has_the_bursts_that_it_touches(simulate):
    """Bytes 6 to 29 in a line of 32 bytes: four bursts of 8 bytes, one request; then one burst."""
    counters = simulate(machine(on_dram(line_bytes=32)), work([[load(6, 24), load(33, 7)]]))

    assert counters.memory.dram_reads.tolist() == [2]
    assert counters.memory.dram_data_clocks.tolist() == [5]


def test_a_store_is_sent_behind_the_load_and_does_not_hold_up(simulate):
    """The store's last beat comes n_rtw + n_wl + 1 clocks after the read; the item was taken long before."""
    unit = on_dram(latency_cycles=2)
    counters = simulate(chain(unit, UNIT), work([[load(0), store(0), emit()]], [[take()]]))

    read_at = CLOSED_BANK - OPEN_ROW
    assert counters.cycles == read_at + 41 + 5 + 1
    assert (counters.unit_stores[0], counters.unit_store_bytes[0]) == (1, 4)
    assert counters.memory.dram_writes.tolist() == [1]


def test_a_unit_misses_and_hits_in_its_cache(simulate):
    """Asked for at 0; the line fills at 3 + 25; the second task's load merges, the third, at 40, hits: here at 43."""
    unit = UNIT._replace(memory=0)
    spec = machine(unit, caches=(CACHE._replace(hit_cycles=3),))
    counters = simulate(spec, work([[load(0)], [load(4)], [38, load(0)]]))

    assert counters.cycles == 40 + 3
    memory = counters.memory
    assert (memory.cache_misses[0], memory.cache_merges[0], memory.cache_hits[0]) == (1, 1, 1)


def test_what_a_unit_clears_it_need_not_fetch(simulate):
    """The CLEAR is answered at 3, the load behind it, looked up in cycle 1, at 4."""
    cache = CACHE._replace(hit_cycles=3, num_ports=1, clear=ClearSpec(8, 0, 8, 0))
    counters = simulate(machine(UNIT._replace(memory=0), caches=(cache,)), work([[clear(0, 64), load(8)]]))

    assert counters.cycles == 1 + 3
    assert (counters.unit_clears[0], counters.unit_loads[0]) == (1, 1)
    assert (counters.memory.cache_clears[0], counters.memory.cache_fetches[0]) == (1, 0)


@pytest.mark.parametrize(("tokens", "cycles"), [(1, 2 * 13 + 12), (2, 2 + 3 * 9 + 1)])
def test_a_pool_lets_in_as_many_as_it_has_tokens(simulate, tokens, cycles):
    """Acquired at 0, in the fifo at 1, taken at 2, 9 steps, released at 12, acquired again at 13."""
    first, second = UNIT._replace(pools=(0,)), UNIT._replace(pools=(0,))
    spec = chain(first, second, pools=(PoolSpec(tokens),))
    counters = simulate(spec, work([[acquire(), emit()]] * 3, [[take(), 9, release()]] * 3))

    assert counters.cycles == cycles
    assert counters.pool_acquired.tolist() == counters.pool_released.tolist() == [3]
    assert counters.pool_peak.tolist() == [tokens]


def test_units_count_in_their_own_clock(simulate):
    spec = machine(UNIT._replace(interval_cycles=7))._replace(period_ticks=5)

    assert simulate(spec, work([[], []])).cycles == 14


def test_no_work_takes_no_time(simulate):
    counters = simulate(chain(UNIT, UNIT), work([], []))

    assert counters.cycles == 0
    assert counters.unit_slots.sum() == 0
