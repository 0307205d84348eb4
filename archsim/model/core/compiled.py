"""Multithreaded cores: who is ready, whose turn it is, and whom an empty slot is charged to; compiled.

Sets of threads are words of 32 bits, so that the next thread of the round is a few operations away.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.trace.records import Op

NO_THREAD = -1
NO_TASK = -1
_NO_WORK = 0  # reason of an empty slot
_WORD_BITS = 32
_DE_BRUIJN = 0x077CB531
_BIT_OF = np.array([(_DE_BRUIJN << bit & 0xFFFFFFFF) >> 27 for bit in range(32)], np.int64).argsort()


class CoreState(NamedTuple):
    """C cores, N threads of all cores, W words to a set of a core's threads."""

    core_of: np.ndarray  # [N] core of the thread
    cursor: np.ndarray  # [N] current record among the loaded ones
    compute_left: np.ndarray  # [N] one-cycle instructions left of the current record
    op: np.ndarray  # [N] Op that closes the current record; END also for a thread without a task
    task: np.ndarray  # [N] task being run, or NO_TASK
    next_task: np.ndarray  # [N] task already meant for the thread, or NO_TASK
    reason: np.ndarray  # [N] why the thread last waited
    ready: np.ndarray  # [C, W] set of threads that can issue
    wake: np.ndarray  # [S, C, W] sets that become ready in the next core cycle that is `slot` modulo S
    pointer: np.ndarray  # [C] where the round goes on
    after_issue: np.ndarray  # [C] core cycle after the last issue
    idle: np.ndarray  # [N] ring of idle threads
    idle_ends: np.ndarray  # [2] longest idle thread and end of the line, counted from the start of the run
    useful: np.ndarray  # [C] slots with an issue
    stalled: np.ndarray  # [C, reasons] slots without
    tasks: np.ndarray  # [C] tasks finished
    emitted: np.ndarray  # [C] EMIT operations


def new_cores(spec: CoreSpec, num_reasons: int, longest_wake_cycles: int) -> CoreState:
    """All threads ready and without a task."""
    num_threads = spec.num_cores * spec.num_threads
    num_words = -(-spec.num_threads // _WORD_BITS)
    num_slots = 1 << longest_wake_cycles.bit_length()

    def per_thread(value: int) -> np.ndarray:
        return np.full(num_threads, value, np.int64)

    def per_core(*shape: int) -> np.ndarray:
        return np.zeros((spec.num_cores, *shape), np.int64)

    ready = per_core(num_words)
    for thread in range(spec.num_threads):
        ready[:, thread // _WORD_BITS] |= 1 << thread % _WORD_BITS
    interleaved = spec.task_order == TaskOrder.INTERLEAVED
    return CoreState(
        core_of=np.arange(num_threads) // spec.num_threads,
        cursor=per_thread(0),
        compute_left=per_thread(0),
        op=per_thread(Op.END),
        task=per_thread(NO_TASK),
        next_task=np.arange(num_threads) if interleaved else per_thread(NO_TASK),
        reason=per_thread(_NO_WORK),
        ready=ready,
        wake=np.zeros((num_slots, spec.num_cores, num_words), np.int64),
        pointer=per_core(),
        after_issue=per_core(),
        idle=per_thread(NO_THREAD),
        idle_ends=np.zeros(2, np.int64),
        useful=per_core(),
        stalled=per_core(num_reasons),
        tasks=per_core(),
        emitted=per_core(),
    )


@njit(forceinline=True)
def _lowest_bit(word):
    """Number of the lowest bit set in a word of 32 bits."""
    return _BIT_OF[((word & -word) * _DE_BRUIJN & 0xFFFFFFFF) >> 27]


@njit
def _pick_behind(state, core, first):
    """First ready thread in the words after word `first`, cyclic, or NO_THREAD."""
    num_words = state.ready.shape[1]
    for i in range(1, num_words + 1):
        number = (first + i) % num_words
        word = state.ready[core, number]
        if word != 0:
            return number * _WORD_BITS + _lowest_bit(word)
    return NO_THREAD


@njit(forceinline=True)
def pick(state, core):
    """First ready thread of the core at or after its pointer, cyclic, or NO_THREAD."""
    pointer = state.pointer[core]
    first = pointer >> 5
    word = state.ready[core, first] & (-1 << (pointer & 31))
    if word != 0:
        return (first << 5) + _lowest_bit(word)
    return _pick_behind(state, core, first)


@njit(forceinline=True)
def park(state, core, thread):
    """The core's thread is no longer ready."""
    state.ready[core, thread >> 5] &= ~(1 << (thread & 31))


@njit(forceinline=True)
def wake_now(state, core, thread):
    """The core's thread is ready in this cycle."""
    state.ready[core, thread >> 5] |= 1 << (thread & 31)


@njit(forceinline=True)
def wake_at(state, cycle, core, thread):
    """The core's thread becomes ready in `cycle`, which is less than S cycles ahead."""
    state.wake[cycle & (state.wake.shape[0] - 1), core, thread >> 5] |= 1 << (thread & 31)


@njit(forceinline=True)
def wake_due(state, cycle):
    """Threads whose wait ends in `cycle` become ready."""
    slot = cycle & (state.wake.shape[0] - 1)
    for core in range(state.ready.shape[0]):
        for word in range(state.ready.shape[1]):
            state.ready[core, word] |= state.wake[slot, core, word]
            state.wake[slot, core, word] = 0


@njit(forceinline=True)
def any_ready(state, cycle):
    """Whether a thread is ready already or becomes so in `cycle`, within S cycles."""
    slot = cycle & (state.wake.shape[0] - 1)
    for core in range(state.ready.shape[0]):
        for word in range(state.ready.shape[1]):
            if (state.ready[core, word] | state.wake[slot, core, word]) != 0:
                return True
    return False


@njit(forceinline=True)
def count_issue(spec, state, cycle, core, thread):
    """Use the core's slot of `cycle`; charge the empty ones before it to what the thread waited for."""
    empty_slots = cycle - state.after_issue[core]
    if empty_slots > 0:
        state.stalled[core, state.reason[core * spec.num_threads + thread]] += empty_slots

    state.useful[core] += 1
    state.after_issue[core] = cycle + 1
    state.pointer[core] = thread + 1 if thread + 1 < spec.num_threads else 0


@njit(forceinline=True)
def read_record(state, number, records, cursor):
    """Thread `number` goes on with the record at `cursor`."""
    state.cursor[number] = cursor
    state.compute_left[number] = records[cursor]["compute"]
    state.op[number] = records[cursor]["op"]


@njit
def join_idle(state, number):
    """Thread `number` goes to the end of the line of idle threads."""
    state.idle[state.idle_ends[1] % len(state.idle)] = number
    state.idle_ends[1] += 1


@njit
def num_idle(state):
    """Threads that wait for a task."""
    return state.idle_ends[1] - state.idle_ends[0]


@njit
def hand_to_idle(spec, state, task):
    """The longest idle thread gets the task and is ready now."""
    number = state.idle[state.idle_ends[0] % len(state.idle)]
    state.idle_ends[0] += 1
    state.next_task[number] = task
    state.reason[number] = _NO_WORK
    core = state.core_of[number]
    wake_now(state, core, number - core * spec.num_threads)


@njit
def retire_idle(state):
    """No task will come: the line of idle threads dissolves."""
    state.idle_ends[0] = state.idle_ends[1]
