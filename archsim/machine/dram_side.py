"""The DRAM beside the compiled machine: how far it may lag behind, and how it catches up."""

from __future__ import annotations

import numpy as np

from archsim.machine.memory import answer_fetch, mshr_of
from archsim.machine.state import Machine, State
from archsim.model.compiled import NEVER, inlined_step
from archsim.model.dram import compiled as dram_model
from archsim.model.dram.compiled import NO_REQUESTER

_CAUGHT_UP = 0  # in place of the end of a window


@inlined_step
def dram_may_wait(spec: Machine, state: State, cycle):
    """Whether nothing that the DRAM has still to do can be answered by `cycle`."""
    first_answer = dram_model.next_due(state.dram) + spec.answer_clocks
    return cycle * spec.core.period_ticks < first_answer * spec.dram.period_ticks


@inlined_step
def play_dram(spec: Machine, state: State, limit):
    """Let the DRAM catch up with the memory clocks before cycle `limit`, unless all that it has to do may wait.

    Returns the next cycle to play: `limit`, the first answer's or a pause's. One loop, not one for each channel: that
    would prepare for all that can happen to the channel.
    """
    dram, run = state.dram, state.run[0]
    if limit < run["pause"] and dram_may_wait(spec, state, limit):
        return limit
    number, end = len(dram.due), _CAUGHT_UP
    while True:
        if number == len(dram.due):
            number, end = 0, _end_of_window(spec, state, limit)
            if end == _CAUGHT_UP:
                break
        elif dram.due[number] < end:
            limit = min(limit, _wake_channel(spec, state, np.uint32(number)))
        else:
            number += 1
    if dram_model.is_log_half_full(dram):
        run["needs_room"] = 1
    if limit > run["pause"] and not (limit == NEVER and dram_model.is_empty(spec.dram, dram)):
        return run["pause"]
    return limit


@inlined_step
def _end_of_window(spec, state, limit):
    """The clock up to which the channels can be played one by one, or _CAUGHT_UP.

    Nothing that happens before it is answered before it, so that none of them learns of another. The run is over with
    the tick in which the last thing on its way arrives: refreshes up to it count.
    """
    dram, run, period = state.dram, state.run[0], spec.dram.period_ticks
    dram_model.find_next_due(dram)
    first = dram_model.next_due(dram)
    end_ticks = min(limit, run["pause"]) * spec.core.period_ticks
    if first * period >= end_ticks:
        return _CAUGHT_UP
    if limit == NEVER:
        is_over = first * period > _last_tick(spec, run) and dram_model.is_empty(spec.dram, dram)
        return _CAUGHT_UP if is_over else first + 1
    return min(first + max(spec.answer_clocks, 1), (end_ticks + period - 1) // period)


@inlined_step
def _last_tick(spec, run):
    """The tick of the last thing that happened."""
    return max(run["cycle"] * spec.core.period_ticks, run["last_clock"] * spec.dram.period_ticks)


@inlined_step
def _wake_channel(spec, state, number):
    """Wake a channel that is due; returns the cycle of the answer that it gives, or NEVER."""
    dram, run = state.dram, state.run[0]
    run["last_clock"] = max(run["last_clock"], dram.due[number])
    requester = dram_model.wake(spec.dram, dram, number)
    if requester == NO_REQUESTER:
        return NEVER
    arrival = dram_model.answer_cycle(spec.dram, dram, number, spec.core.period_ticks)
    owner, _, place = mshr_of(requester)
    state.waits.dram[owner, place] = dram.waits[number]
    answer_fetch(state, arrival, len(spec.caches), requester)
    return arrival
