"""On-chip locks granted in the order of asking, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.model.compiled import record, step
from archsim.model.locks.spec import LocksSpec

NOBODY = -1
NOT_HOLDER = -2  # the thread that unlocks does not hold the lock
_EVERYBODY = -3  # the holder of every lock of an ideal table


LOCK = record("holder", "first", "last")
WAITER = record("behind", "asked")
LOCK_COUNTS = record("taken", "waited", "wait_cycles")


class LocksState(NamedTuple):
    """L locks, N threads. A lock's line of waiting threads is a chain through `behind`."""

    locks: np.ndarray  # LOCK [L] who holds it, who heads and who ends its line, each a thread or NOBODY
    waiters: np.ndarray  # WAITER [N] who stands behind the thread, core cycle in which it asked
    counts: np.ndarray  # LOCK_COUNTS [1] grants, requests that had to wait, core cycles that those waited


def new_locks(spec: LocksSpec, num_threads: int) -> LocksState:
    """All locks free."""
    holder = _EVERYBODY if spec.is_ideal else NOBODY
    locks = np.full(spec.num_locks, np.array((holder, NOBODY, NOBODY), LOCK))
    return LocksState(locks, np.zeros(num_threads, WAITER), np.zeros(1, LOCK_COUNTS))


@step
def take(state, cycle, number, thread):
    """Whether the thread has the lock now; if not, it stands in line from `cycle` on."""
    lock, counts = state.locks[number], state.counts[0]
    if lock["holder"] == NOBODY:
        lock["holder"] = thread
        counts["taken"] += 1
        return True

    if lock["holder"] == _EVERYBODY:
        counts["taken"] += 1
        return True
    counts["waited"] += 1
    state.waiters[thread]["asked"] = cycle
    state.waiters[thread]["behind"] = NOBODY
    if lock["first"] == NOBODY:
        lock["first"] = thread
    else:
        state.waiters[lock["last"]]["behind"] = thread
    lock["last"] = thread
    return False


@step
def release(state, cycle, number, thread):
    """The thread that gets the lock in `cycle`, NOBODY if no one waits, NOT_HOLDER if it is not the caller's."""
    lock, counts = state.locks[number], state.counts[0]
    if lock["holder"] != thread:
        return NOBODY if lock["holder"] == _EVERYBODY else NOT_HOLDER

    heir = lock["first"]
    lock["holder"] = heir
    if heir != NOBODY:
        lock["first"] = state.waiters[heir]["behind"]
        counts["taken"] += 1
        counts["wait_cycles"] += cycle - state.waiters[heir]["asked"]
    return heir
