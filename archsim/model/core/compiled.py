"""Multithreaded cores: who is ready, whose turn it is, and whom an empty slot is charged to; compiled.

Sets of threads are words of 32 bits, so that the next thread of the round is a few operations away.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, inlined
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.trace.records import Op

NO_THREAD = -1
NO_TASK = -1
_NO_WORK = 0  # reason of an empty slot
_WORD_BITS = 32
_DE_BRUIJN = 0x077CB531
_BIT_OF = np.array([(_DE_BRUIJN << bit & 0xFFFFFFFF) >> 27 for bit in range(32)], np.int64).argsort()


_THREAD_FIELDS = (
    "core",  # its core
    "place",  # its number in the core
    "cursor",  # current record among the loaded ones
    "compute_left",  # one-cycle instructions left of the record
    "op",  # Op that closes the record; END also for a thread without a task
    "task",  # being run, or NO_TASK
    "next_task",  # already meant for the thread, or NO_TASK
    "reason",  # why it last waited
)
_CORE_FIELDS = (
    "pointer",  # where the round goes on
    "after_issue",  # core cycle after the last issue
    "useful",  # slots with an issue
    "tasks",  # finished
    "emitted",  # EMIT operations
)
THREAD = np.dtype([(name, np.int64) for name in _THREAD_FIELDS], align=True)
CORE = np.dtype([(name, np.int64) for name in _CORE_FIELDS], align=True)


class CoreState(NamedTuple):
    """C cores, N threads of all cores, W words to a set of a core's threads."""

    threads: np.ndarray  # THREAD [N]
    cores: np.ndarray  # CORE [C]
    ready: np.ndarray  # [C, W] set of threads that can issue
    wake: np.ndarray  # [S, C, W] sets that become ready in the next core cycle that is `slot` modulo S
    stalled: np.ndarray  # [C, reasons] slots without an issue
    idle: np.ndarray  # [N] ring of idle threads
    idle_ends: np.ndarray  # [2] longest idle thread and end of the line, counted from the start of the run


def new_cores(spec: CoreSpec, num_reasons: int, longest_wake_cycles: int) -> CoreState:
    """All threads ready and without a task."""
    num_threads = spec.num_cores * spec.num_threads
    num_words = -(-spec.num_threads // _WORD_BITS)
    num_slots = 1 << longest_wake_cycles.bit_length()

    threads = np.zeros(num_threads, THREAD)
    threads["core"], threads["place"] = np.divmod(np.arange(num_threads), spec.num_threads)
    threads["op"] = Op.END
    threads["task"] = NO_TASK
    threads["next_task"] = np.arange(num_threads) if spec.task_order == TaskOrder.INTERLEAVED else NO_TASK
    threads["reason"] = _NO_WORK
    ready = np.zeros((spec.num_cores, num_words), np.int64)
    for place in range(spec.num_threads):
        ready[:, place // _WORD_BITS] |= 1 << place % _WORD_BITS
    return CoreState(
        threads=threads,
        cores=np.zeros(spec.num_cores, CORE),
        ready=ready,
        wake=np.zeros((num_slots, spec.num_cores, num_words), np.int64),
        stalled=np.zeros((spec.num_cores, num_reasons), np.int64),
        idle=np.zeros(num_threads, np.int64),
        idle_ends=np.zeros(2, np.int64),
    )


@inlined
def _lowest_bit(word):
    """Number of the lowest bit set in a word of 32 bits."""
    return _BIT_OF[((word & -word) * _DE_BRUIJN & 0xFFFFFFFF) >> 27]


@compiled
def _pick_behind(state, core, first):
    """First ready thread in the words after word `first`, cyclic, or NO_THREAD."""
    num_words = state.ready.shape[1]
    for i in range(1, num_words + 1):
        number = (first + i) % num_words
        word = state.ready[core, number]
        if word != 0:
            return number * _WORD_BITS + _lowest_bit(word)
    return NO_THREAD


@inlined
def pick(state, core):
    """First ready thread of the core at or after its pointer, cyclic, or NO_THREAD."""
    pointer = state.cores[core]["pointer"]
    first = pointer >> 5
    word = state.ready[core, first] & (-1 << (pointer & 31))
    if word != 0:
        return (first << 5) + _lowest_bit(word)
    return _pick_behind(state, core, first)


@inlined
def park(state, thread):
    """The thread is no longer ready."""
    place = thread["place"]
    state.ready[thread["core"], place >> 5] &= ~(1 << (place & 31))


@inlined
def wake_now(state, thread):
    """The thread is ready in this cycle."""
    place = thread["place"]
    state.ready[thread["core"], place >> 5] |= 1 << (place & 31)


@inlined
def wake_at(state, cycle, thread):
    """The thread becomes ready in `cycle`, which is less than S cycles ahead."""
    slot = cycle & (state.wake.shape[0] - 1)
    place = thread["place"]
    state.wake[slot, thread["core"], place >> 5] |= 1 << (place & 31)


@inlined
def wake_due(state, cycle):
    """Threads whose wait ends in `cycle` become ready."""
    slot = cycle & (state.wake.shape[0] - 1)
    for core in range(state.ready.shape[0]):
        for word in range(state.ready.shape[1]):
            state.ready[core, word] |= state.wake[slot, core, word]
            state.wake[slot, core, word] = 0


@inlined
def any_ready(state, cycle):
    """Whether a thread is ready already or becomes so in `cycle`, within S cycles."""
    slot = cycle & (state.wake.shape[0] - 1)
    for core in range(state.ready.shape[0]):
        for word in range(state.ready.shape[1]):
            if (state.ready[core, word] | state.wake[slot, core, word]) != 0:
                return True
    return False


@inlined
def count_issue(spec, state, cycle, thread):
    """Use the core's slot of `cycle`; charge the empty ones before it to what the thread waited for."""
    core = state.cores[thread["core"]]
    empty_slots = cycle - core["after_issue"]
    if empty_slots > 0:
        state.stalled[thread["core"], thread["reason"]] += empty_slots

    core["useful"] += 1
    core["after_issue"] = cycle + 1
    behind = thread["place"] + 1
    core["pointer"] = behind if behind < spec.num_threads else 0


@inlined
def read_record(thread, records, cursor):
    """The thread goes on with the record at `cursor`."""
    thread["cursor"] = cursor
    thread["compute_left"] = records[cursor]["compute"]
    thread["op"] = records[cursor]["op"]


@compiled
def join_idle(state, number):
    """Thread `number` goes to the end of the line of idle threads."""
    state.idle[state.idle_ends[1] % len(state.idle)] = number
    state.idle_ends[1] += 1


@inlined
def num_idle(state):
    """Threads that wait for a task."""
    return state.idle_ends[1] - state.idle_ends[0]


@compiled
def hand_to_idle(state, task):
    """The longest idle thread gets the task and is ready now."""
    thread = state.threads[state.idle[state.idle_ends[0] % len(state.idle)]]
    state.idle_ends[0] += 1
    thread["next_task"] = task
    thread["reason"] = _NO_WORK
    wake_now(state, thread)


@compiled
def retire_idle(state):
    """No task will come: the line of idle threads dissolves."""
    state.idle_ends[0] = state.idle_ends[1]
