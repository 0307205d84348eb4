"""Work that cannot be played, machines that get stuck: both models refuse in the same words."""

import numpy as np
import pytest

from archsim.errors import ArchsimError, DeadlockError
from archsim.model.pool.spec import PoolSpec
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import PipelineWork
from tests.machine.build import CACHE
from tests.machine.pipeline.build import (
    UNIT,
    acquire,
    both_models,
    chain,
    clear,
    delayed,
    emit,
    load,
    machine,
    mark,
    on_dram,
    release,
    take,
    work,
)

pytestmark = both_models


def refused(simulate, spec, played):
    with pytest.raises(ArchsimError) as error:
        simulate(spec, played)
    return str(error.value)


@pytest.mark.parametrize(
    ("steps", "what"),
    [
        ([emit(1)], "unit a: EMIT of output 1: they are numbered from 0 to 0"),
        ([take()], "unit a: TAKE: the unit has no input"),
        ([acquire()], "unit a: ACQUIRE: the unit has no pool"),
        ([load(0)], "unit a: LOAD: the unit has no memory"),
        ([emit(0, 3)], "unit a: EMIT of 3 bytes to output 0, which is a fifo"),
        ([mark(0)], "unit a: MARK of 0 bytes to output 0, which is a fifo"),
        ([(Op.LOCK, 0, 0)], "unit a: LOCK is an operation of threads"),
        ([-3, emit()], "unit a: EMIT after -3 steps"),
    ],
)
def test_records_that_a_unit_cannot_play(simulate, steps, what):
    assert refused(simulate, chain(UNIT, UNIT), work([steps], [[take()]])) == what


def test_a_task_must_begin_with_its_item(simulate):
    expected = "unit b: a task must open with TAKE, because the unit has inputs"

    assert refused(simulate, chain(UNIT, UNIT), work([[emit()]], [[2, take()]])) == expected
    assert refused(simulate, chain(UNIT, UNIT), work([[emit()]], [[]])) == expected


@pytest.mark.parametrize("size", [0, 33, -1])
def test_items_that_do_not_fit_a_delay_stream(simulate, size):
    what = refused(simulate, delayed(UNIT, UNIT), work([[emit(0, size)]], [[take()]]))

    assert (
        what == f"unit a: EMIT of {size} bytes to output 0: a delay stream that holds items of 1 to 32 bytes"
    )


def test_a_cache_without_clear_bits(simulate):
    spec = machine(UNIT._replace(memory=0), caches=(CACHE,))

    assert (
        refused(simulate, spec, work([[clear(0, 8)]]))
        == "unit a: CLEAR: the unit has no cache with clear bits"
    )


@pytest.mark.parametrize(
    ("step", "what"), [(load(-4), "addresses begin at 0"), (load(0, 0), "LOAD of 0 bytes")]
)
def test_accesses_that_make_no_sense(simulate, step, what):
    assert what in refused(simulate, machine(on_dram()), work([[step]]))


def test_an_operation_that_does_not_exist(simulate):
    records = np.array([(0, 0, 0, 77), (0, 0, 0, Op.END)], RECORD)
    played = PipelineWork(("a",), iter([(Tasks(np.array([0, 2]), records),)]))

    assert refused(simulate, machine(UNIT), played) == "unit a: no operation has the number 77"


def test_a_task_without_an_end(simulate):
    records = np.array([(0, 3, 0, Op.LOAD)], RECORD)
    played = PipelineWork(("a",), iter([(Tasks(np.array([0, 1]), records),)]))

    assert refused(simulate, machine(on_dram()), played) == "unit a: a task does not close with END"


def test_items_that_nobody_takes(simulate):
    what = refused(simulate, chain(UNIT, UNIT), work([[emit()]] * 3, [[take()]]))

    assert what == "the work ended, but 2 items from a to b were never taken"


def test_tokens_that_nobody_gives_back(simulate):
    spec = machine(UNIT._replace(pools=(0,)), pools=(PoolSpec(3),))

    assert "2 tokens of pool 0 were never released" in refused(
        simulate, spec, work([[acquire()], [acquire()]])
    )


def test_a_deadlock_says_who_waits_for_what(simulate):
    spec = chain(UNIT._replace(pools=(0,)), UNIT._replace(pools=(0,)), UNIT, pools=(PoolSpec(1),))
    played = work([[acquire(), emit()]] * 2, [[take()], [take(), release(), emit()]], [[take()]])

    with pytest.raises(DeadlockError) as error:
        simulate(spec, played)
    lines = str(error.value).splitlines()
    assert lines[0].startswith("deadlock in cycle ")
    assert lines[1:] == [
        "a waits for a token of the pool of a, b",
        "b waits for an item from a",
        "c waits for an item from b",
    ]


def test_a_channel_needs_two_ends(simulate):
    spec = chain(UNIT, UNIT)
    loose = spec._replace(units=(spec.units[0], UNIT))

    assert refused(simulate, loose, work([], [])) == "channel 0: 1 units emit into it, 0 take from it"


def test_a_chunk_must_be_for_all_units(simulate):
    played = PipelineWork(("a", "b"), work([[]]).chunks)

    assert "a chunk holds the tasks of 1 units; there are 2" in refused(simulate, chain(UNIT, UNIT), played)
