"""One issue slot a cycle, round-robin threads, who gets which task, and whom an empty slot is charged to."""

import pytest

from archsim.errors import ArchsimError
from archsim.machine.counters import STALL_LOCK, STALL_NO_WORK
from archsim.model.core.spec import TaskOrder
from tests.machine.build import (
    CACHE,
    CLOSED_BANK,
    CORE,
    EMIT,
    MACHINE,
    both_models,
    load,
    lock,
    machine,
    stalls,
    store,
    unlock,
    work,
)

pytestmark = both_models


def test_one_cycle_instructions_issue_one_a_cycle(simulate):
    counters = simulate(MACHINE, work([5], [3, EMIT], [2]))

    assert counters.cycles == 5 + 4 + 2
    assert counters.useful.tolist() == [11]
    assert counters.emitted.tolist() == [1]
    assert counters.tasks.tolist() == [3]
    assert counters.stalled.sum() == 0


def test_cycles_do_not_depend_on_the_ticks_of_a_cycle(simulate):
    slow = MACHINE._replace(core=CORE._replace(period_ticks=7))

    assert simulate(slow, work([5])).cycles == 5


def test_no_tasks_take_no_time(simulate):
    counters = simulate(MACHINE, work())

    assert counters.cycles == 0
    assert counters.useful.tolist() == [0]
    assert counters.stalled.sum() == 0


def test_empty_tasks_take_no_issue_slot(simulate):
    counters = simulate(MACHINE, work([], [], [2], [], [3], []))

    assert counters.tasks.tolist() == [6]
    assert counters.cycles == 5


def test_only_empty_tasks_take_no_time(simulate):
    counters = simulate(machine(num_cores=2, num_threads=2), work([], [], [], [], []))

    assert counters.cycles == 0
    assert counters.tasks.tolist() == [3, 2]


def test_threads_take_turns(simulate):
    """Slots 0 to 4: compute, compute, LOCK granted to thread 2, thread 0 waits from 3, thread 1 from 4.

    Thread 2 unlocks in slot 10, thread 0 in slot 16, thread 1 in slot 22.
    """
    hold = [lock(1), 5, unlock(1)]
    counters = simulate(machine(num_threads=3), work([1, *hold], [1, *hold], hold))

    assert counters.cycles == 23
    assert counters.lock_wait_ticks == (10 - 3) + (16 - 4)


def test_a_stall_on_memory_is_charged_to_where_the_request_is(simulate):
    """The first LOAD goes to the DRAM, the second hits."""
    spec = MACHINE._replace(caches=(CACHE._replace(hit_cycles=7),))
    counters = simulate(spec, work([load(0), load(0), 1]))

    assert stalls(counters) == {"0.lookup": 7 + 6, "dram.activation": 13, "dram.bus": 11}


def test_a_wait_whose_thread_never_issues_again_is_no_work(simulate):
    counters = simulate(MACHINE, work([load(0)]))

    assert counters.cycles == 1 + CLOSED_BANK
    assert stalls(counters) == {"no_work": CLOSED_BANK}


def test_empty_slots_are_charged_to_the_thread_that_ends_them(simulate):
    """Core 0 waits for the lock while core 1 holds it: slots 2 to 10 of core 0 are empty."""
    counters = simulate(machine(num_cores=2), work([1, lock(0), 2], [lock(0), 8, unlock(0), 3]))

    # Core 1: LOCK in 0, compute 1 to 8, UNLOCK in 9, so core 0 issues again in 10 and 11.
    assert stalls(counters) == {"no_work": counters.cycles - 12, "lock": 8}
    assert counters.cycles == 13
    assert counters.stalled[1].sum() == 0


def test_another_thread_hides_the_wait(simulate):
    """While thread 0 waits for the DRAM, thread 1 issues all but one of the slots."""
    compute = CLOSED_BANK - 1
    counters = simulate(machine(num_threads=2), work([load(0), 1], [compute]))

    assert counters.cycles == 1 + CLOSED_BANK + 1
    assert stalls(counters) == {"dram.bus": 1}


def test_a_thread_remembers_its_reason(simulate):
    """Thread 1 last waited for a lock; the empty slots before its next issue are the lock's, though it is ready."""
    spec = machine(num_cores=2)
    counters = simulate(spec, work([lock(0), 4, unlock(0), load(0)], [1, lock(0), 1, unlock(0), load(0), 1]))

    # Core 1 asks in slot 1, core 0 unlocks in slot 5: slots 2 to 5 of core 1 are empty.
    assert counters.stalled[1, STALL_LOCK] == 4
    assert stalls(counters, 1)["dram.bus"] > 0


def test_a_store_waits_for_its_line(simulate):
    counters = simulate(MACHINE, work([store(0), 1]))

    assert counters.cycles == 1 + CLOSED_BANK + 1


def test_interleaved_threads_own_their_tasks(simulate):
    """Threads 0 to 3 on two cores own tasks 0 4, 1 5, 2 and 3."""
    counters = simulate(machine(num_cores=2, num_threads=2), work([10], [1], [3], [5], [2], [4]))

    assert counters.tasks.tolist() == [4, 2]
    assert counters.useful.tolist() == [10 + 1 + 2 + 4, 3 + 5]
    assert counters.cycles == 17


def test_first_free_gives_the_next_task_to_the_first_thread_that_asks(simulate):
    """Core 0 is busy with the long task; core 1 takes all others."""
    spec = machine(num_cores=2)
    spec = spec._replace(core=spec.core._replace(task_order=TaskOrder.FIRST_FREE))
    counters = simulate(spec, work([20], [3], [5], [7], [2]))

    assert counters.tasks.tolist() == [1, 4]
    assert counters.cycles == 20
    assert counters.stalled[1, STALL_NO_WORK] == 3


def test_cores_that_ask_at_once_are_served_by_index(simulate):
    spec = machine(num_cores=2)
    spec = spec._replace(core=spec.core._replace(task_order=TaskOrder.FIRST_FREE))
    counters = simulate(spec, work([4], [4], [1, EMIT]))

    assert counters.tasks.tolist() == [2, 1]
    assert counters.emitted.tolist() == [1, 0]


def test_a_finished_thread_passes_its_slot_on(simulate):
    """Thread 0 retires in slot 2 (after slots 0 and 1 went to threads 0 and 1), thread 1 issues in it."""
    counters = simulate(machine(num_threads=2), work([1], [3]))

    assert counters.cycles == 4
    assert counters.stalled.sum() == 0


def test_an_access_across_a_line_is_refused(simulate):
    with pytest.raises(ArchsimError, match="line"):
        simulate(MACHINE, work([load(4, num_bytes=8)]))


def test_an_access_up_to_the_end_of_a_line_is_not(simulate):
    assert simulate(MACHINE, work([load(4, num_bytes=4)])).cycles == 1 + CLOSED_BANK
