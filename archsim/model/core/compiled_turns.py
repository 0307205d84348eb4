"""Whose turn it is on the compiled cores, and when a thread comes to an operation: from there to there they are played.

A turn is one round of a core's ready threads in the order of their places. All a thread does between two operations
is to issue one instruction a turn, so the turn of its operation is known when it begins its record (`turns`), and the
cycle as long as the same threads are ready (`plan`). Until then nothing is done but to count, when a thread becomes
ready or the cycle has come, what was issued since (`play_to`).
"""

from __future__ import annotations

import numpy as np

from archsim.jit import lowest_bit, num_bits
from archsim.lanes import LANES, least_lane
from archsim.model.compiled import NEVER, inlined_step, step
from archsim.model.core.compiled import (
    NO_THREAD,
    PARKED,
    PLACE_BITS,
    WORD_SHIFT,
    first_ready,
    nth_ready,
    num_ready_before,
    take_woken,
)
from archsim.trace.records import Op

_PLACE = (1 << PLACE_BITS) - 1


@inlined_step
def is_turn_of_first(state, core, cycle):
    """Whether in `cycle` nobody wakes and the thread that comes to its operation first does it: it is not an END."""
    owner = state.cores[core]
    if owner["first_slot"] != cycle or owner["next_wake"] == cycle:
        return False
    return state.threads[np.uint32(owner["first_thread"] + (owner["first"] & _PLACE))]["op"] != Op.END


@inlined_step
def issue_first(state, core, cycle):
    """Let the core's ready threads issue in turn up to that one's operation in `cycle`; its place and turn."""
    owner = state.cores[core]
    place, turn = owner["first"] & _PLACE, owner["first"] >> PLACE_BITS
    owner["useful"] += cycle + 1 - owner["next_slot"]
    owner["next_slot"] = cycle + 1
    owner["num_passed"] = num_ready_before(state, core, place) + 1
    owner["next_place"] = place + 1
    owner["turn"] = turn
    owner["played_to"] = cycle
    return place, turn


@inlined_step
def play_to(state, core, cycle):
    """Let the core's ready threads, if there are any, issue in turn up to before `cycle`; none does its operation."""
    owner = state.cores[core]
    if owner["played_to"] < cycle and owner["next_slot"] < cycle and owner["num_ready"] > 0:
        owner["useful"] += cycle - owner["next_slot"]
        _turn(state, core, cycle - owner["next_slot"])
        owner["next_slot"] = cycle
    owner["played_to"] = cycle


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
    owner["next_place"] = nth_ready(state, core, last) + 1


@step
def play_all_to(state, cycle):
    """Let the ready threads of all cores issue in turn up to before `cycle`, in which any may still wake."""
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
    owner = state.cores[thread["core"]]
    own = ((turn + thread["compute"]) << PLACE_BITS) + np.int64(thread["place"])
    state.turns[thread["core"], thread["place"]] = own
    owner["first"] = min(owner["first"], own)


@inlined_step
def leave(state, core, number):
    """The thread, which comes to its operation first, is about to do it: the first one is among the others now.

    What was just written is slow to read again, so they are looked through before, not after.
    """
    owner, first, place = state.cores[core], PARKED, np.int64(state.threads[number]["place"])
    for start in range(0, owner["num_threads"], LANES):
        first = min(first, least_lane(state.turns, core, start, place - start))
    owner["first"] = first


@inlined_step
def come_back(state, core, number):
    """The thread has not done its operation after all."""
    own = state.turns[core, state.threads[number]["place"]]
    state.cores[core]["first"] = min(state.cores[core]["first"], own)


@inlined_step
def does_operation(state, number, turn):
    """Whether the thread has nothing left to compute at `turn`."""
    thread = state.threads[number]
    return state.turns[thread["core"], thread["place"]] >> PLACE_BITS == turn


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
    owner = state.cores[core]
    first, owner["first_slot"] = owner["first"], NEVER
    if first != PARKED:
        before = num_ready_before(state, core, first & _PLACE) - np.int64(owner["num_passed"])
        slots = before + ((first >> PLACE_BITS) - owner["turn"]) * np.int64(owner["num_ready"])
        owner["first_slot"] = owner["next_slot"] + slots
    state.due[core] = min(owner["first_slot"], owner["next_wake"])


@inlined_step
def park(state, number):
    """The thread, which has left, is no longer ready."""
    thread = state.threads[number]
    owner = state.cores[thread["core"]]
    state.ready[thread["word"]] &= ~thread["bit"]
    state.turns[thread["core"], thread["place"]] = PARKED
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
    _be_due(state, thread["core"], cycle)


@inlined_step
def wake_at(state, cycle, number):
    """The thread's wait ends in `cycle`, less than S cycles ahead; it joins at once if its core has come so far."""
    thread = state.threads[number]
    owner = state.cores[thread["core"]]
    if owner["next_slot"] == cycle:
        join(state, number)
        owner["first_slot"] = NEVER  # as it was planned without the thread
    else:
        state.wake[np.uint32(cycle & (len(state.wake) - 1)), thread["word"]] |= thread["bit"]
        owner["num_waking"] += 1
        owner["next_wake"] = min(owner["next_wake"], cycle)
    _be_due(state, thread["core"], cycle)


@inlined_step
def _be_due(state, core, cycle):
    """The core is due in `cycle` at the latest."""
    state.due[core] = min(state.due[core], cycle)
    state.next_due[0] = min(state.next_due[0], cycle)


@inlined_step
def join_woken(state, cycle, core):
    """The core's threads whose wait ends in `cycle`, up to which it has been played, become ready."""
    owner = state.cores[core]
    if owner["next_wake"] != cycle:
        return
    for word in range(owner["first_word"], owner["first_word"] + owner["num_words"]):
        slot = np.uint32(cycle & (len(state.wake) - 1))
        owner["num_waking"] -= np.uint32(num_bits(state.wake[slot, word]))
        threads = take_woken(state, cycle, word)
        first = np.int64(owner["first_thread"]) + (np.int64(word - owner["first_word"]) << WORD_SHIFT)
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
