"""A source that makes a task every interval, for the thread that idles longest."""

from archsim.machine.counters import STALL_MEMORY, STALL_NO_WORK
from archsim.model.core.spec import TaskOrder
from archsim.model.fifo.spec import FifoSpec
from archsim.model.unit.spec import UnitSpec
from tests.machine.build import EMIT, both_models, load, machine, stalls, work

pytestmark = both_models


def fed(interval_cycles, num_entries=2, **shape):
    spec = machine(**shape, source=UnitSpec(interval_cycles), fifo=FifoSpec(num_entries))
    return spec._replace(core=spec.core._replace(task_order=TaskOrder.FIRST_FREE))


def test_a_slow_source_sets_the_pace(simulate):
    """Tasks are made in slots 0, 11 and 22, each handed to the idle thread and issued at once."""
    counters = simulate(fed(11), work([2], [2], [3]))

    assert counters.cycles == 22 + 3
    assert stalls(counters) == {"no_work": (11 - 2) + (22 - 13)}


def test_the_pace_is_counted_in_core_cycles(simulate):
    spec = fed(11)
    spec = spec._replace(core=spec.core._replace(period_ticks=5))

    assert simulate(spec, work([2], [2], [3])).cycles == 25


def test_at_most_one_task_is_made_in_a_cycle(simulate):
    """With an interval of 1 core 1 gets its first task in slot 1."""
    counters = simulate(fed(1, num_cores=2), work([5], [5]))

    assert counters.cycles == 6
    assert counters.tasks.tolist() == [1, 1]


def test_the_longest_idle_thread_is_handed_the_task(simulate):
    """Slot 0: core 0 takes task 0 from the fifo, core 1 idles; core 0 idles from slot 2 on.

    Task 1 (slot 7) goes to core 1, task 2 (slot 14) to core 0, task 3 (slot 21) to core 1.
    """
    counters = simulate(fed(7, num_cores=2), work([2], [EMIT], [2], [EMIT]))

    assert counters.emitted.tolist() == [0, 2]
    assert counters.cycles == 22


def test_waiting_for_a_task_is_charged_as_no_work_even_after_a_wait_for_memory(simulate):
    counters = simulate(fed(100), work([load(0), 1], [1]))

    assert counters.cycles == 101
    assert counters.stalled[0, STALL_NO_WORK] == 100 - counters.stalled[0, STALL_MEMORY:].sum() - 2


def test_a_source_that_is_held_back_makes_the_next_task_when_there_is_room(simulate):
    """Task 1 is made in slot 3, task 2 is due in slot 6 but there is room in slot 21 only, when task 1 has left."""
    counters = simulate(fed(3, num_entries=1), work([20], [5], [1], [1]))

    assert counters.cycles == 20 + 5 + 1 + 1
    assert counters.stalled.sum() == 0


def test_the_interval_runs_from_the_task_that_was_made(simulate):
    """Task 2 is due in slot 18 but made in slot 31 (task 1 left in slot 30), so task 3 comes in slot 31 + 9."""
    counters = simulate(fed(9, num_entries=1), work([30], [1], [1], [1]))

    assert counters.cycles == 41


def test_no_tasks_retire_everybody(simulate):
    assert simulate(fed(11, num_cores=2, num_threads=2), work()).cycles == 0


def test_empty_tasks_go_through_the_source_too(simulate):
    """Made in slots 0, 4, 8, 12: the run is over when the last is finished."""
    counters = simulate(fed(4), work([], [], [], []))

    assert counters.cycles == 12
    assert counters.tasks.tolist() == [4]
