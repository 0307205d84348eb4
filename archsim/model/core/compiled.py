"""Multithreaded cores: their threads, who of them is ready, and who waits for a cycle or a task; compiled.

Sets of threads are words of 32 bits, so that threads are counted and found with a few operations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import lowest_bit, num_bits
from archsim.lanes import padded
from archsim.model.compiled import NEVER, inlined_step, record, step
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.trace.records import Op

NO_TASK = -1
NO_THREAD = -1
_NO_WORK = 0  # reason of an empty slot
WORD_SHIFT = 5
_WORD_BITS = 1 << WORD_SHIFT
PLACE_BITS = 16
PARKED = 1 << 62  # in `turns`, of a thread that is not ready


_THREAD_INDICES = (
    "core",
    "place",  # among the core's threads
    "word",  # which word of the sets of threads holds its bit
    "cursor",  # current record among the loaded ones
    "reason",  # why it last waited
)
_THREAD_FIELDS = (
    "bit",  # its bit
    "compute",  # one-cycle instructions of the record
    "op",  # Op that closes the record; END also for a thread without a task
    "task",  # being run, or NO_TASK
    "next_task",  # already meant for the thread, or NO_TASK
)
_CORE_INDICES = (
    "first_word",  # where its threads begin in a set of threads
    "num_words",  # of its threads, with a place behind the last one
    "first_thread",
    "num_threads",
    "next_place",  # where the turn goes on
    "num_ready",  # ready threads
    "num_passed",  # of them, those before `next_place`
    "num_waking",  # threads whose wait ends in a cycle that is known
)
_CORE_FIELDS = (
    "turn",  # number of the turn that the last issue belonged to
    "first",  # of `turns` of its threads, but for the one that is doing its operation
    "first_slot",  # cycle of that operation, or NEVER
    "next_slot",  # first cycle whose slot is not accounted for: it is still to come, or nobody has been ready since
    "played_to",  # cycle in which the core was last looked at
    "next_wake",  # first cycle in which a thread wakes, as far as is known, or NEVER
    "useful",  # slots with an issue
    "tasks",  # finished
    "emitted",  # EMIT operations
)
THREAD = record(*_THREAD_FIELDS, indices=_THREAD_INDICES)  # a line of the host's cache
CORE = record(*_CORE_FIELDS, indices=_CORE_INDICES)


class CoreState(NamedTuple):
    """C cores, N threads of all cores, W words to a set of all cores' threads; every core begins a new word.

    T is the number of threads of a core, padded to LANES.
    """

    threads: np.ndarray  # THREAD [N]
    turns: (
        np.ndarray
    )  # [C, T] turn in which a core's thread, if it is ready, does its operation, and its place; or PARKED
    cores: np.ndarray  # CORE [C]
    due: np.ndarray  # [C] core cycle in which a thread wakes or does its operation, or NEVER
    next_due: np.ndarray  # [1] the first of them, when all cores have been looked at
    ready: np.ndarray  # [W] set of threads that can issue
    woken: np.ndarray  # [W] set of threads whose wait ends in this cycle
    wake: np.ndarray  # [S, W] sets of those whose wait ends in the next core cycle that is `slot` modulo S
    stalled: np.ndarray  # [C, reasons] slots without an issue
    idle: np.ndarray  # [N] ring of idle threads
    idle_ends: np.ndarray  # [2] longest idle thread and end of the line, counted from the start of the run


def new_cores(spec: CoreSpec, num_reasons: int, longest_wake_cycles: int) -> CoreState:
    """All threads ready and without a task."""
    num_threads = spec.num_cores * spec.num_threads
    words_per_core = spec.num_threads // _WORD_BITS + 1
    num_words = spec.num_cores * words_per_core
    num_slots = 1 << longest_wake_cycles.bit_length()

    core, place = np.divmod(np.arange(num_threads), spec.num_threads)
    threads = np.zeros(num_threads, THREAD)
    threads["core"], threads["place"] = core, place
    threads["word"] = core * words_per_core + place // _WORD_BITS
    threads["bit"] = 1 << place % _WORD_BITS
    threads["op"] = Op.END
    threads["task"] = NO_TASK
    threads["next_task"] = np.arange(num_threads) if spec.task_order == TaskOrder.INTERLEAVED else NO_TASK
    threads["reason"] = _NO_WORK
    ready = np.zeros(num_words, np.int64)
    np.bitwise_or.at(ready, threads["word"], threads["bit"])
    turns = np.full((spec.num_cores, padded(spec.num_threads)), PARKED)
    turns[core, place] = place
    cores = np.zeros(spec.num_cores, CORE)
    cores["first_word"] = np.arange(spec.num_cores) * words_per_core
    cores["num_words"] = words_per_core
    cores["first_thread"] = np.arange(spec.num_cores) * spec.num_threads
    cores["num_threads"] = spec.num_threads
    cores["num_ready"] = spec.num_threads
    cores["next_wake"] = NEVER
    return CoreState(
        threads=threads,
        turns=turns,
        cores=cores,
        due=np.zeros(spec.num_cores, np.int64),
        next_due=np.zeros(1, np.int64),
        ready=ready,
        woken=np.zeros(num_words, np.int64),
        wake=np.zeros((num_slots, num_words), np.int64),
        stalled=np.zeros((spec.num_cores, num_reasons), np.int64),
        idle=np.zeros(num_threads, np.int64),
        idle_ends=np.zeros(2, np.int64),
    )


@inlined_step
def first_ready(state, core, place):
    """Place of the core's first ready thread at `place` or behind it, or NO_THREAD."""
    owner = state.cores[core]
    word = np.uint32(owner["first_word"] + (place >> WORD_SHIFT))
    threads = state.ready[word] & (-1 << (place & (_WORD_BITS - 1)))
    if owner["num_words"] > 1:
        word, threads = _in_later_word(state.ready, owner, word, threads)
    if threads == 0:
        return NO_THREAD
    return (np.int64(word - owner["first_word"]) << WORD_SHIFT) + lowest_bit(threads)


@step
def _in_later_word(ready, owner, word, threads):
    """The first word from this one on in which there are threads, and they; these are those of this word."""
    end = np.int64(owner["first_word"]) + np.int64(owner["num_words"])
    while threads == 0 and np.int64(word) + 1 < end:
        word = np.uint32(word + 1)
        threads = ready[word]
    return word, threads


@inlined_step
def num_ready_before(state, core, end):
    """Ready threads of the core before the place `end`."""
    owner = state.cores[core]
    last = np.uint32(owner["first_word"] + (end >> WORD_SHIFT))
    count = num_bits(state.ready[last] & ~(-1 << (end & (_WORD_BITS - 1))))
    if owner["num_words"] > 1:
        for word in range(owner["first_word"], last):
            count += num_bits(state.ready[word])
    return count


@inlined_step
def nth_ready(state, core, number):
    """Place of the core's ready thread that has `number` ready ones before it."""
    owner = state.cores[core]
    word, threads = owner["first_word"], state.ready[owner["first_word"]]
    if owner["num_words"] > 1:
        word, threads, number = _word_of(state.ready, word, number)
    for _ in range(number):
        threads &= threads - 1
    return (np.int64(word - owner["first_word"]) << WORD_SHIFT) + lowest_bit(threads)


@step
def _word_of(ready, word, number):
    """The word from this one on with the thread that has `number` before it; the word's threads; those before in it."""
    while number >= num_bits(ready[word]):
        number -= num_bits(ready[word])
        word = np.uint32(word + 1)
    return word, ready[word], number


@inlined_step
def wake_due(state, cycle, core):
    """The core's threads whose wait ends in `cycle` become ready, for who does not ask whose turn it is."""
    owner = state.cores[core]
    for word in range(owner["first_word"], owner["first_word"] + owner["num_words"]):
        state.ready[word] |= take_woken(state, cycle, word)


@inlined_step
def take_woken(state, cycle, word):
    """The threads of the word whose wait ends in `cycle`."""
    slot = np.uint32(cycle & (len(state.wake) - 1))
    threads = state.woken[word] | state.wake[slot, word]
    state.woken[word] = state.wake[slot, word] = 0
    return threads


@step
def next_wake(state, cycle, limit):
    """First cycle after `cycle` and before `limit` in which a wait of anyone ends by itself, or `limit`."""
    num_slots, num_words = state.wake.shape
    for later in range(cycle + 1, min(cycle + num_slots, limit)):
        for word in range(num_words):
            if state.wake[later & (num_slots - 1), word] != 0:
                return later
    return limit


@inlined_step
def read_record(state, thread, records, cursor):
    """The thread goes on with the record at `cursor`. EMITs on the way, which nothing can hold up, are counted now."""
    cursor = np.uint32(cursor)
    compute, op = np.int64(records[cursor]["compute"]), np.int64(records[cursor]["op"])
    while op == Op.EMIT:
        state.cores[thread["core"]]["emitted"] += 1
        cursor = np.uint32(cursor + 1)
        compute += 1 + np.int64(records[cursor]["compute"])
        op = np.int64(records[cursor]["op"])
    thread["cursor"] = cursor
    thread["compute"] = compute
    thread["op"] = op


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
    """The longest idle thread gets the task; its number, for the caller to wake it."""
    number = state.idle[state.idle_ends[0] % len(state.idle)]
    state.idle_ends[0] += 1
    state.threads[number]["next_task"] = task
    state.threads[number]["reason"] = _NO_WORK
    return number


@step
def retire_idle(state):
    """No task will come: the line of idle threads dissolves."""
    state.idle_ends[0] = state.idle_ends[1]
