"""What the front of a unit waits for in the memory, by hand, on both models; one tick is a cycle and a clock.

A line of a closed bank of the DRAM, asked for in cycle 0, is here in cycle 25: the slot of cycle 0 comes before the
memory's clock 0, the row takes n_rcd_read = 13, the data n_cl + 1 = 12, the last of which is the next cycle.
"""

import numpy as np

from archsim.model.unit.spec import Slot
from tests.machine.build import CACHE, address, cause_names
from tests.machine.pipeline.build import (
    STREAM,
    UNIT,
    both_models,
    delayed,
    emit,
    load,
    machine,
    mark,
    on_dram,
    store,
    take,
    work,
)

pytestmark = both_models

A, B, C = address(), address(column=4), address(column=8)
FIRST = {"dram.queue": 1, "dram.activation": 13, "dram.bus": 11}


def waits(counters):
    """Cycles in which memory held the only unit back, by cause."""
    assert np.array_equal(counters.unit_waits.sum(axis=1), counters.unit_slots[:, Slot.MEMORY])
    names = cause_names(len(counters.memory.cache_hits))
    return {name: n for name, n in zip(names, counters.unit_waits[0].tolist(), strict=True) if n}


def test_a_load_waits_for_a_free_access(simulate):
    """B is asked for when A has come; nothing waits for B."""
    counters = simulate(machine(on_dram(outstanding=1)), work([[load(A), load(B)]]))

    assert waits(counters) == FIRST


def test_any_access_ends_that_wait_and_another_begins(simulate):
    """A and B come in 25 and 27, C is asked for in 25, the next one in 27."""
    steps = [load(A), load(B), load(C), load(C)]
    counters = simulate(machine(on_dram(outstanding=2)), work([steps]))

    assert waits(counters) == {**FIRST, "dram.bus": 11 + 2}


def test_a_load_waits_for_the_oldest_one_to_be_here(simulate):
    counters = simulate(machine(on_dram(in_flight=1)), work([[load(A), load(B)]]))

    assert waits(counters) == FIRST


def test_of_several_lines_the_last_one_counts(simulate):
    """Its RD is n_ccd after the first one's, for which it waits in the queue."""
    counters = simulate(machine(on_dram(in_flight=1)), work([[load(A, 16), load(B)]]))

    assert waits(counters) == {**FIRST, "dram.queue": 1 + 2}


def test_a_store_waits_for_a_free_access(simulate):
    """Each joins a cycle before it is asked for. The bank is closed, so the first WR is n_rcd_write after that."""
    unit = on_dram(outstanding=1, in_flight=1)
    counters = simulate(machine(unit), work([[store(A), store(B), store(C)]]))

    assert waits(counters)["dram.activation"] == 7


def test_a_cache_is_waited_for_as_by_a_core(simulate):
    """The first access misses, the second one hits, asked for in cycle 28."""
    unit = UNIT._replace(memory=0, outstanding=1)
    spec = machine(unit, caches=(CACHE._replace(hit_cycles=3),))
    counters = simulate(spec, work([[load(A), load(A), load(A)]]))

    assert waits(counters) == {"0.lookup": 4 + 3, "dram.activation": 13, "dram.bus": 11}


def waits_of_consumer(counters):
    """Cycles in which the second unit waited for its delay stream's transfers, by cause, and those without work."""
    assert np.array_equal(counters.unit_waits.sum(axis=1), counters.unit_slots[:, Slot.MEMORY])
    names = cause_names(len(counters.memory.cache_hits))
    found = {name: n for name, n in zip(names, counters.unit_waits[1].tolist(), strict=True) if n}
    return found, counters.unit_slots[1, Slot.NO_WORK]


def test_an_item_on_its_way_through_a_delay_stream_is_waited_for(simulate):
    """Put in and marked in 1, sent in 2; its WR is in 9, its data there in 15; its RD, n_wtr later, in 52."""
    counters = simulate(delayed(UNIT, UNIT), work([[emit(0, 5), mark()]], [[take()]]))

    causes = {"dram.activation": 9 - 2, "dram.turnaround": 52 - 15, "dram.bus": 15 - 9 + 12}
    assert waits_of_consumer(counters) == (causes, 3)


def test_before_its_marker_there_is_no_work(simulate):
    """The item is there long before; the MARK is seen in 202, in which the RD is sent, too."""
    counters = simulate(delayed(UNIT, UNIT), work([[emit(0, 8), 200, mark()]], [[take()]]))

    assert waits_of_consumer(counters) == ({"dram.bus": 12}, 203)


def test_the_next_line_is_waited_for_when_the_first_one_came(simulate):
    """An item of two lines: one RD n_ccd = 2 after the other, or when the first data are here."""
    steps = [[emit(0, 16), 200, mark()]], [[take()]]
    both = simulate(delayed(UNIT, UNIT), work(*steps))
    one = simulate(delayed(UNIT, UNIT, STREAM._replace(outstanding=1)), work(*steps))

    assert waits_of_consumer(both) == ({"dram.bus": 12 + 2}, 203)
    assert waits_of_consumer(one) == ({"dram.bus": 12 + 12}, 203)


def test_an_answer_to_a_store_of_its_own_ends_no_such_wait(simulate):
    """Its second item is marked in 202 and read from 203 on, after the store of 200, which is answered in 206.

    The first item is taken in 67, after the second one's WR in 11, whose data are there in 17.
    """
    steps = [[emit(0, 8), mark()], [emit(0, 8), 200, mark()]], [[take(), 199 - 67, store(C)], [take()]]
    counters = simulate(delayed(UNIT, on_dram()), work(*steps))

    first = {"dram.queue": 17 - 15, "dram.activation": 7, "dram.turnaround": 37, "dram.bus": 6 + 12}
    second = {"dram.queue": 206 - 203, "dram.turnaround": 37, "dram.bus": 12}
    causes = {name: first[name] + second.get(name, 0) for name in first}
    assert waits_of_consumer(counters) == (causes, 3 + 5)
