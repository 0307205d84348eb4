"""Locks are granted in the order of asking; what cannot be granted is said."""

import pytest

from archsim.errors import ArchsimError, DeadlockError
from archsim.machine.counters import STALL_LOCK
from tests.machine.build import CORE, EMIT, MACHINE, both_models, lock, machine, unlock, work

pytestmark = both_models


def test_a_free_lock_costs_its_issue_slot_only(simulate):
    counters = simulate(MACHINE, work([lock(3), 2, unlock(3), 1]))

    assert counters.cycles == 5
    assert (counters.locks_taken, counters.locks_waited, counters.lock_wait_ticks) == (1, 0, 0)


def test_a_held_lock_is_handed_over_at_unlock(simulate):
    """Core 0 unlocks in slot 6; core 1, which asked in slot 2, issues again in slot 7."""
    spec = machine(num_cores=2)
    spec = spec._replace(core=spec.core._replace(period_ticks=7))
    counters = simulate(spec, work([lock(0), 5, unlock(0)], [2, lock(0), 3, unlock(0)]))

    assert counters.cycles == 7 + 3 + 1
    assert (counters.locks_taken, counters.locks_waited) == (2, 1)
    assert counters.lock_wait_ticks == (6 - 2) * 7
    assert counters.stalled[1, STALL_LOCK] == 4


def test_waiting_threads_are_served_in_the_order_of_asking(simulate):
    """Core 2 asks in slot 1, core 1 in slot 2: core 2 holds the lock from slot 10 to 14, core 1 from 14 on."""
    hold = [3, unlock(0)]
    counters = simulate(
        machine(num_cores=3), work([lock(0), 9, unlock(0)], [2, lock(0), *hold], [1, lock(0), *hold])
    )

    assert counters.lock_wait_ticks == (10 - 1) + (14 - 2)
    assert counters.stalled[1, STALL_LOCK] == 14 - 2
    assert counters.stalled[2, STALL_LOCK] == 10 - 1


def test_asking_in_the_same_slot_counts_by_core_index(simulate):
    hold = [lock(0), 3, unlock(0)]
    counters = simulate(machine(num_cores=3), work(hold, hold, hold))

    assert counters.stalled[:, STALL_LOCK].tolist() == [0, 4, 8]


def test_a_lock_freed_by_a_lower_core_is_free_in_the_same_slot(simulate):
    """Core 0 unlocks in slot 4, in which core 1 asks."""
    counters = simulate(machine(num_cores=2), work([lock(0), 3, unlock(0)], [4, lock(0)]))

    assert counters.locks_waited == 0


def test_a_lock_freed_by_a_higher_core_is_not(simulate):
    """Core 1 unlocks in slot 4, after core 0 asked in it; the grant comes in the same slot."""
    counters = simulate(machine(num_cores=2), work([4, lock(0)], [lock(0), 3, unlock(0)]))

    assert counters.locks_waited == 1
    assert counters.lock_wait_ticks == 0
    assert counters.cycles == 5


def test_different_locks_do_not_meet(simulate):
    counters = simulate(machine(num_cores=2), work([lock(0), 5, unlock(0)], [lock(1), 5, unlock(1)]))

    assert counters.locks_waited == 0
    assert counters.cycles == 7


def test_a_deadlock_says_what_every_thread_waits_for(simulate):
    crossed = work([lock(1), 3, lock(2)], [lock(2), 3, lock(1)])

    with pytest.raises(DeadlockError) as caught:
        simulate(machine(num_cores=2), crossed)

    assert "core 0 thread 0 waits for lock 2" in str(caught.value)
    assert "core 1 thread 0 waits for lock 1" in str(caught.value)


def test_a_lock_that_is_never_given_back_is_a_deadlock(simulate):
    with pytest.raises(DeadlockError, match="core 0 thread 1 waits for lock 0, held by core 0 thread 0"):
        simulate(machine(num_threads=2), work([lock(0)], [3, lock(0), 2, EMIT, EMIT]))


def test_asking_twice_is_a_deadlock(simulate):
    with pytest.raises(DeadlockError, match="lock 0"):
        simulate(MACHINE, work([lock(0), lock(0)]))


@pytest.mark.parametrize("number", [-1, 4])
def test_a_lock_out_of_range_is_refused(simulate, number):
    with pytest.raises(ArchsimError, match="lock"):
        simulate(MACHINE, work([lock(number)]))


def test_unlocking_what_another_thread_holds_is_refused(simulate):
    with pytest.raises(ArchsimError, match="lock 1"):
        simulate(machine(num_threads=2), work([lock(1), 5, unlock(1)], [2, unlock(1), EMIT, 1]))


def test_unlocking_a_free_lock_is_refused(simulate):
    assert CORE.num_threads == 1
    with pytest.raises(ArchsimError, match="lock 1"):
        simulate(MACHINE, work([unlock(1)]))


def test_an_ideal_table_grants_everything_at_once(simulate):
    """Both cores hold lock 0 from slot 0 on; unlocking costs its issue slot only."""
    hold = [lock(0), 5, unlock(0), 1]
    spec = machine(num_cores=2)
    counters = simulate(spec._replace(locks=spec.locks._replace(is_ideal=True)), work(hold, hold))

    assert counters.cycles == 8
    assert (counters.locks_taken, counters.locks_waited, counters.lock_wait_ticks) == (2, 0, 0)
    assert counters.stalled[:, STALL_LOCK].tolist() == [0, 0]
