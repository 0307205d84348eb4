"""Multithreaded cores: who is ready, whose turn it is, and when somebody does more than compute; compiled.

Between such events a core issues one-cycle instructions of its ready threads in turn, and nothing need be done: it
catches up when something comes in between (`play_to`). A round of the ready threads, in the order of their places, is
a turn; `turns` holds in which one each thread comes to the operation that closes its record.

Sets of threads are words of 32 bits, so that threads are counted and found with a few operations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import lowest_bit, num_bits
from archsim.model.compiled import NEVER, inlined_step, record, step
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.trace.records import Op

NO_TASK = -1
NO_THREAD = -1
_NO_WORK = 0  # reason of an empty slot
_WORD_SHIFT = 5
_WORD_BITS = 1 << _WORD_SHIFT
_PLACE_BITS = 16
_PARKED = 1 << 62  # in `turns`, of a thread that is not ready


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
    "first",  # of `turns` of its threads
    "first_slot",  # cycle of that operation, or NEVER
    "next_slot",  # first core cycle that has not been played
    "next_wake",  # first cycle in which a thread wakes, as far as is known, or NEVER
    "useful",  # slots with an issue
    "tasks",  # finished
    "emitted",  # EMIT operations
)
THREAD = record(*_THREAD_FIELDS, indices=_THREAD_INDICES)  # a line of the host's cache
CORE = record(*_CORE_FIELDS, indices=_CORE_INDICES)


class CoreState(NamedTuple):
    """C cores, N threads of all cores, W words to a set of all cores' threads; every core begins a new word."""

    threads: np.ndarray  # THREAD [N]
    turns: (
        np.ndarray
    )  # [N] turn in which the thread, if it is ready, does its operation, and its place; or _PARKED
    cores: np.ndarray  # CORE [C]
    due: np.ndarray  # [C] core cycle in which a thread wakes or does its operation, or NEVER
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
    cores = np.zeros(spec.num_cores, CORE)
    cores["first_word"] = np.arange(spec.num_cores) * words_per_core
    cores["num_words"] = words_per_core
    cores["first_thread"] = np.arange(spec.num_cores) * spec.num_threads
    cores["num_threads"] = spec.num_threads
    cores["num_ready"] = spec.num_threads
    cores["next_wake"] = NEVER
    return CoreState(
        threads=threads,
        turns=place.astype(np.int64),
        cores=cores,
        due=np.zeros(spec.num_cores, np.int64),
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
    word = np.uint32(owner["first_word"] + (place >> _WORD_SHIFT))
    threads = state.ready[word] & (-1 << (place & (_WORD_BITS - 1)))
    if owner["num_words"] > 1:
        word, threads = _in_later_word(state.ready, owner, word, threads)
    if threads == 0:
        return NO_THREAD
    return (np.int64(word - owner["first_word"]) << _WORD_SHIFT) + lowest_bit(threads)


@step
def _in_later_word(ready, owner, word, threads):
    """The first word from this one on in which there are threads, and they; these are those of this word."""
    end = owner["first_word"] + owner["num_words"]
    while threads == 0 and word + 1 < end:
        word = np.uint32(word + 1)
        threads = ready[word]
    return word, threads


@inlined_step
def _num_ready(state, core, end):
    """Ready threads of the core before the place `end`."""
    owner = state.cores[core]
    last = np.uint32(owner["first_word"] + (end >> _WORD_SHIFT))
    count = num_bits(state.ready[last] & ~(-1 << (end & (_WORD_BITS - 1))))
    if owner["num_words"] > 1:
        for word in range(owner["first_word"], last):
            count += num_bits(state.ready[word])
    return count


@inlined_step
def _place_of(state, core, number):
    """Place of the core's ready thread that has `number` ready ones before it."""
    owner = state.cores[core]
    word, threads = owner["first_word"], state.ready[owner["first_word"]]
    if owner["num_words"] > 1:
        word, threads, number = _word_of(state.ready, word, number)
    for _ in range(number):
        threads &= threads - 1
    return (np.int64(word - owner["first_word"]) << _WORD_SHIFT) + lowest_bit(threads)


@step
def _word_of(ready, word, number):
    """The word from this one on with the thread that has `number` before it; the word's threads; those before in it."""
    while number >= num_bits(ready[word]):
        number -= num_bits(ready[word])
        word = np.uint32(word + 1)
    return word, ready[word], number


@inlined_step
def play_to(state, core, cycle):
    """Let the core's ready threads, if there are any, issue in turn up to before `cycle`; none does its operation."""
    owner = state.cores[core]
    if owner["next_slot"] < cycle and owner["num_ready"] > 0:
        owner["useful"] += cycle - owner["next_slot"]
        if owner["first_slot"] == cycle and owner["next_wake"] != cycle and not _ends(state, owner):
            _turn_to_first(state, core)
        else:
            _turn(state, core, cycle - owner["next_slot"])
        owner["next_slot"] = cycle


@inlined_step
def _ends(state, owner):
    """Whether the thread that comes to its operation first is at the end of its task."""
    place = owner["first"] & ((1 << _PLACE_BITS) - 1)
    return state.threads[np.uint32(owner["first_thread"] + place)]["op"] == Op.END


@inlined_step
def _turn_to_first(state, core):
    """It is the turn of the thread that comes to its operation first; it issues, and nobody becomes ready before."""
    owner = state.cores[core]
    place = owner["first"] & ((1 << _PLACE_BITS) - 1)
    owner["turn"] = owner["first"] >> _PLACE_BITS
    owner["num_passed"] = _num_ready(state, core, place)
    owner["next_place"] = place


@inlined_step
def _turn(state, core, num_slots):
    """Ready threads issue in so many slots, at least one; the turn goes on behind the last of them."""
    owner = state.cores[core]
    num_ready = np.int64(owner["num_ready"])
    last = np.int64(owner["num_passed"]) + num_slots - 1
    if last >= num_ready:
        owner["turn"] += last // num_ready
        last %= num_ready
    owner["num_passed"] = last + 1
    owner["next_place"] = _place_of(state, core, last) + 1


@step
def play_all_to(state, cycle):
    """The same for all cores."""
    for core in range(len(state.cores)):
        play_to(state, core, cycle)


@inlined_step
def next_in_turn(state, core):
    """Place of the thread that issues next, or NO_THREAD, and the number of its turn."""
    owner = state.cores[core]
    place = first_ready(state, core, np.int64(owner["next_place"]))
    if place != NO_THREAD:
        return place, owner["turn"]
    return first_ready(state, core, 0), owner["turn"] + 1


@inlined_step
def go_on(state, number, turn):
    """The thread, at `turn`, goes on with the record that it has read."""
    thread = state.threads[number]
    state.turns[number] = ((turn + thread["compute"]) << _PLACE_BITS) + np.int64(thread["place"])


@inlined_step
def does_operation(state, number, turn):
    """Whether the thread has nothing left to compute at `turn`."""
    return state.turns[number] >> _PLACE_BITS == turn


@inlined_step
def use_slot(state, cycle, core, place, turn):
    """The thread at this place and turn issues in `cycle`; the turn goes on behind it."""
    owner = state.cores[core]
    owner["useful"] += 1
    owner["next_slot"] = cycle + 1
    owner["num_passed"] = (owner["num_passed"] if turn == owner["turn"] else 0) + 1
    owner["next_place"] = place + 1
    owner["turn"] = turn


@inlined_step
def plan(state, core):
    """Find out when the core is due next."""
    owner, first = state.cores[core], _PARKED
    for number in range(owner["first_thread"], owner["first_thread"] + owner["num_threads"]):
        first = min(first, state.turns[number])
    owner["first"], owner["first_slot"] = first, NEVER
    if first != _PARKED:
        before = _num_ready(state, core, first & ((1 << _PLACE_BITS) - 1)) - np.int64(owner["num_passed"])
        turns = (first >> _PLACE_BITS) - owner["turn"]
        owner["first_slot"] = owner["next_slot"] + before + turns * np.int64(owner["num_ready"])
    state.due[core] = min(owner["first_slot"], owner["next_wake"])


@inlined_step
def park(state, number):
    """The thread is no longer ready."""
    thread = state.threads[number]
    owner = state.cores[thread["core"]]
    state.ready[thread["word"]] &= ~thread["bit"]
    state.turns[number] = _PARKED
    owner["num_ready"] -= 1
    owner["num_passed"] -= 1 if thread["place"] < owner["next_place"] else 0


@inlined_step
def join(state, number):
    """The thread is ready: it issues when its place comes, in this turn or the next one."""
    thread = state.threads[number]
    owner = state.cores[thread["core"]]
    state.ready[thread["word"]] |= thread["bit"]
    is_passed = 1 if thread["place"] < owner["next_place"] else 0
    go_on(state, number, owner["turn"] + is_passed)
    owner["num_ready"] += 1
    owner["num_passed"] += is_passed


@inlined_step
def wake_now(state, cycle, number):
    """The thread's wait ends in `cycle`, which is being played."""
    thread = state.threads[number]
    state.woken[thread["word"]] |= thread["bit"]
    state.cores[thread["core"]]["next_wake"] = cycle
    state.due[thread["core"]] = cycle


@inlined_step
def wake_at(state, cycle, number):
    """The thread's wait ends in `cycle`, which is less than S cycles ahead; at once if its core has come so far."""
    thread = state.threads[number]
    owner = state.cores[thread["core"]]
    if owner["next_slot"] == cycle:
        join(state, number)
    else:
        state.wake[np.uint32(cycle & (len(state.wake) - 1)), thread["word"]] |= thread["bit"]
        owner["num_waking"] += 1
        owner["next_wake"] = min(owner["next_wake"], cycle)
    state.due[thread["core"]] = min(state.due[thread["core"]], cycle)


@inlined_step
def wake_due(state, cycle, core):
    """The core's threads whose wait ends in `cycle` become ready; for who does not ask whose turn it is."""
    owner = state.cores[core]
    for word in range(owner["first_word"], owner["first_word"] + owner["num_words"]):
        state.ready[word] |= _take_woken(state, cycle, word)


@inlined_step
def _take_woken(state, cycle, word):
    """The threads of the word whose wait ends in `cycle`."""
    slot = np.uint32(cycle & (len(state.wake) - 1))
    threads = state.woken[word] | state.wake[slot, word]
    state.woken[word] = state.wake[slot, word] = 0
    return threads


@inlined_step
def join_woken(state, cycle, core):
    """The same for a core that has been played to `cycle`."""
    owner = state.cores[core]
    if owner["next_wake"] != cycle:
        return
    for word in range(owner["first_word"], owner["first_word"] + owner["num_words"]):
        slot = np.uint32(cycle & (len(state.wake) - 1))
        owner["num_waking"] -= np.uint32(num_bits(state.wake[slot, word]))
        threads = _take_woken(state, cycle, word)
        first = np.int64(owner["first_thread"]) + (np.int64(word - owner["first_word"]) << _WORD_SHIFT)
        while threads != 0:
            join(state, np.uint32(first + lowest_bit(threads)))
            threads &= threads - 1
    owner["next_wake"] = _next_wake_of(state, cycle, owner) if owner["num_waking"] > 0 else NEVER


@step
def _next_wake_of(state, cycle, owner):
    """First cycle after `cycle` in which a wait of one of the core's threads ends, of which there are some."""
    while True:
        cycle += 1
        for word in range(owner["first_word"], owner["first_word"] + owner["num_words"]):
            if state.wake[cycle & (len(state.wake) - 1), word] != 0:
                return cycle


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
def read_record(thread, records, cursor):
    """The thread goes on with the record at `cursor`."""
    thread["cursor"] = cursor
    thread["compute"] = records[cursor]["compute"]
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
def hand_to_idle(state, cycle, task):
    """The longest idle thread gets the task and is ready in `cycle`, which is being played."""
    number = state.idle[state.idle_ends[0] % len(state.idle)]
    thread = state.threads[number]
    state.idle_ends[0] += 1
    thread["next_task"] = task
    thread["reason"] = _NO_WORK
    wake_now(state, cycle, number)


@step
def retire_idle(state):
    """No task will come: the line of idle threads dissolves."""
    state.idle_ends[0] = state.idle_ends[1]
