"""Multithreaded cores: who is ready, whose turn it is, and whom an empty slot is charged to; compiled.

Sets of threads are words of 32 bits, so that the next thread of the round is a few operations away.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.model.compiled import inlined_step, record, step
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.trace.records import Op

NO_TASK = -1
_NO_WORK = 0  # reason of an empty slot
_WORD_BITS = 32
_DE_BRUIJN = 0x077CB531
_BIT_OF = (
    np.array([(_DE_BRUIJN << bit & 0xFFFFFFFF) >> 27 for bit in range(32)], np.int64)
    .argsort()
    .astype(np.uint32)
)


_THREAD_INDICES = (
    "word",  # which word of the sets of threads holds its bit
    "cursor",  # current record among the loaded ones
    "reason",  # why it last waited
)
_THREAD_FIELDS = (
    "bit",  # its bit
    "compute_left",  # one-cycle instructions left of the record
    "op",  # Op that closes the record; END also for a thread without a task
    "task",  # being run, or NO_TASK
    "next_task",  # already meant for the thread, or NO_TASK
)
_CORE_INDICES = (
    "first_word",  # where its threads begin in a set of threads
    "num_words",  # of its threads
    "word",  # in which the round goes on,
)
_CORE_FIELDS = (
    "ahead",  # with these of its bits
    "after_issue",  # core cycle after the last issue
    "useful",  # slots with an issue
    "tasks",  # finished
    "emitted",  # EMIT operations
)
THREAD = record(*_THREAD_FIELDS, indices=_THREAD_INDICES)  # at most a line of the host's cache
CORE = record(*_CORE_FIELDS, indices=_CORE_INDICES)


class CoreState(NamedTuple):
    """C cores, N threads of all cores, W words to a set of all cores' threads; every core begins a new word."""

    threads: np.ndarray  # THREAD [N]
    cores: np.ndarray  # CORE [C]
    first_of: np.ndarray  # uint32 [W] number of the thread that the word's lowest bit stands for
    ready: np.ndarray  # [W] set of threads that can issue
    wake: np.ndarray  # [S, W] sets that become ready in the next core cycle that is `slot` modulo S
    stalled: np.ndarray  # [C, reasons] slots without an issue
    idle: np.ndarray  # [N] ring of idle threads
    idle_ends: np.ndarray  # [2] longest idle thread and end of the line, counted from the start of the run


def new_cores(spec: CoreSpec, num_reasons: int, longest_wake_cycles: int) -> CoreState:
    """All threads ready and without a task."""
    num_threads = spec.num_cores * spec.num_threads
    words_per_core = -(-spec.num_threads // _WORD_BITS)
    num_words = spec.num_cores * words_per_core
    num_slots = 1 << longest_wake_cycles.bit_length()

    core, place = np.divmod(np.arange(num_threads), spec.num_threads)
    threads = np.zeros(num_threads, THREAD)
    threads["word"] = core * words_per_core + place // _WORD_BITS
    threads["bit"] = 1 << place % _WORD_BITS
    threads["op"] = Op.END
    threads["task"] = NO_TASK
    threads["next_task"] = np.arange(num_threads) if spec.task_order == TaskOrder.INTERLEAVED else NO_TASK
    threads["reason"] = _NO_WORK
    ready = np.zeros(num_words, np.int64)
    np.bitwise_or.at(ready, threads["word"], threads["bit"])
    cores = np.zeros(spec.num_cores, CORE)
    cores["first_word"] = cores["word"] = np.arange(spec.num_cores) * words_per_core
    cores["num_words"] = words_per_core
    cores["ahead"] = -1
    return CoreState(
        threads=threads,
        cores=cores,
        first_of=np.array(
            [np.flatnonzero(threads["word"] == word)[0] for word in range(num_words)], np.uint32
        ),
        ready=ready,
        wake=np.zeros((num_slots, num_words), np.int64),
        stalled=np.zeros((spec.num_cores, num_reasons), np.int64),
        idle=np.zeros(num_threads, np.int64),
        idle_ends=np.zeros(2, np.int64),
    )


@step
def _next_word(ready, owner):
    """The core's next word, cyclic, that has a ready thread; if none has, the word where the round goes on."""
    word, first = np.int64(owner["word"]), np.int64(owner["first_word"])
    end = first + np.int64(owner["num_words"])
    while True:
        word = word + 1 if word + 1 < end else first
        if ready[word] != 0 or word == owner["word"]:
            return np.uint32(word)


@inlined_step
def pick(state, core):
    """Word and bit of the core's first ready thread where the round goes on; the bit is 0 if there is none."""
    owner = state.cores[core]
    word = owner["word"]
    threads = state.ready[word]
    ahead = threads & owner["ahead"]
    if ahead == 0 and owner["num_words"] > 1:
        word = _next_word(state.ready, owner)
        threads = state.ready[word]
    first = ahead if ahead != 0 else threads
    return word, first & -first


@inlined_step
def number_of(state, word, bit):
    """Number of the thread with this bit."""
    place = _BIT_OF[np.uint32((bit * _DE_BRUIJN & 0xFFFFFFFF) >> 27)]
    return np.uint32(state.first_of[word] + place)


@inlined_step
def park(state, thread):
    """The thread is no longer ready."""
    state.ready[thread["word"]] &= ~thread["bit"]


@inlined_step
def wake_now(state, thread):
    """The thread is ready in this cycle."""
    state.ready[thread["word"]] |= thread["bit"]


@inlined_step
def wake_at(state, cycle, thread):
    """The thread becomes ready in `cycle`, which is less than S cycles ahead."""
    state.wake[np.uint32(cycle & (len(state.wake) - 1)), thread["word"]] |= thread["bit"]


@inlined_step
def wake_due(state, cycle, core):
    """The core's threads whose wait ends in `cycle` become ready."""
    slot, word = np.uint32(cycle & (len(state.wake) - 1)), state.cores[core]["first_word"]
    state.ready[word] |= state.wake[slot, word]
    state.wake[slot, word] = 0
    if state.cores[core]["num_words"] > 1:
        _wake_more(state, slot, word, state.cores[core]["num_words"])


@step
def _wake_more(state, slot, first, num_words):
    """The same for the core's other words."""
    for more in range(1, num_words):
        word = np.uint32(first + more)
        state.ready[word] |= state.wake[slot, word]
        state.wake[slot, word] = 0


@step
def next_wake(state, cycle, limit):
    """First cycle after `cycle` and before `limit` in which a wait ends by itself, or `limit`."""
    num_slots, num_words = state.wake.shape
    for later in range(cycle + 1, min(cycle + num_slots, limit)):
        for word in range(num_words):
            if state.wake[later & (num_slots - 1), word] != 0:
                return later
    return limit


@inlined_step
def use_slot(state, cycle, core):
    """The core issues in `cycle`."""
    owner = state.cores[core]
    owner["useful"] += 1
    owner["after_issue"] = cycle + 1


@inlined_step
def go_round(state, core, word, bit):
    """The round goes on behind the thread with this bit."""
    state.cores[core]["word"] = word
    state.cores[core]["ahead"] = -(bit << 1)


@inlined_step
def read_record(thread, records, cursor):
    """The thread goes on with the record at `cursor`."""
    thread["cursor"] = cursor
    thread["compute_left"] = records[cursor]["compute"]
    thread["op"] = records[cursor]["op"]


@step
def join_idle(state, number):
    """Thread `number` goes to the end of the line of idle threads."""
    state.idle[state.idle_ends[1] % len(state.idle)] = number
    state.idle_ends[1] += 1


@inlined_step
def num_idle(state):
    """Threads that wait for a task."""
    return state.idle_ends[1] - state.idle_ends[0]


@step
def hand_to_idle(state, task):
    """The longest idle thread gets the task and is ready now."""
    thread = state.threads[state.idle[state.idle_ends[0] % len(state.idle)]]
    state.idle_ends[0] += 1
    thread["next_task"] = task
    thread["reason"] = _NO_WORK
    wake_now(state, thread)


@step
def retire_idle(state):
    """No task will come: the line of idle threads dissolves."""
    state.idle_ends[0] = state.idle_ends[1]
