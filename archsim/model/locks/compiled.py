"""On-chip locks granted in the order of asking, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit

NOBODY = -1
NOT_HOLDER = -2  # the thread that unlocks does not hold the lock


class LocksState(NamedTuple):
    """L locks, N threads. A lock's line of waiting threads is a chain through `behind`."""

    holder: np.ndarray  # [L] thread that holds the lock, or NOBODY
    first: np.ndarray  # [L] head of the line, or NOBODY
    last: np.ndarray  # [L] end of the line, or NOBODY
    behind: np.ndarray  # [N] who stands behind the thread
    asked: np.ndarray  # [N] core cycle in which the waiting thread asked
    taken: np.ndarray  # [1] grants
    waited: np.ndarray  # [1] requests that found the lock held
    wait_cycles: np.ndarray  # [1] core cycles between asking and grant, summed over the waiting


def new_locks(num_locks: int, num_threads: int) -> LocksState:
    """All locks free."""
    lock_fields = [np.full(num_locks, NOBODY, np.int64) for _ in range(3)]
    thread_fields = [np.full(num_threads, NOBODY, np.int64) for _ in range(2)]
    counts = [np.zeros(1, np.int64) for _ in range(3)]
    return LocksState(*lock_fields, *thread_fields, *counts)


@njit
def take(state, cycle, lock, thread):
    """Whether the thread has the lock now; if not, it stands in line from `cycle` on."""
    if state.holder[lock] == NOBODY:
        state.holder[lock] = thread
        state.taken[0] += 1
        return True

    state.waited[0] += 1
    state.asked[thread] = cycle
    state.behind[thread] = NOBODY
    if state.first[lock] == NOBODY:
        state.first[lock] = thread
    else:
        state.behind[state.last[lock]] = thread
    state.last[lock] = thread
    return False


@njit
def release(state, cycle, lock, thread):
    """The thread that gets the lock in `cycle`, NOBODY if no one waits, NOT_HOLDER if it is not the caller's."""
    if state.holder[lock] != thread:
        return NOT_HOLDER

    heir = state.first[lock]
    state.holder[lock] = heir
    if heir != NOBODY:
        state.first[lock] = state.behind[heir]
        state.taken[0] += 1
        state.wait_cycles[0] += cycle - state.asked[heir]
    return heir
