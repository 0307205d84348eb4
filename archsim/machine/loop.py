"""The main loop of the compiled machine: the phases of one core cycle, and the way to the next one that matters.

Time is counted in core cycles. The order of what meets in one cycle is README.md's: fills, source, issue, lookups;
then the DRAM plays the memory clocks that lie before the next cycle visited.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import njit
from archsim.machine.dram_side import dram_may_wait, play_dram
from archsim.machine.issue import BAD_UNLOCK, NEEDS_TASKS, PLAYED, issue, make_task, source_due
from archsim.machine.memory import deliver_due, look_up_due
from archsim.machine.state import Machine, State
from archsim.model.compiled import NEVER, inlined_step
from archsim.model.core.compiled_turns import play_all_to

OVER, NEEDS_ROOM, PAUSED = (
    BAD_UNLOCK + n for n in (1, 2, 3)
)  # why `play` returns, besides NEEDS_TASKS, BAD_UNLOCK

__all__ = ["BAD_UNLOCK", "NEEDS_ROOM", "NEEDS_TASKS", "OVER", "PAUSED", "play"]


@njit(error_model="numpy", _nrt=False, no_cfunc_wrapper=True)
def play(spec: Machine, state: State):
    """Play until the work is over or the caller must help; the status says which."""
    run = state.run[0]
    cycle = run["cycle"]
    while cycle != NEVER:
        if run["horizon"] <= cycle:
            if run["pause"] <= cycle:
                run["cycle"] = cycle
                play_all_to(state.core, cycle)
                return PAUSED
            _begin(spec, state, cycle)
        if state.core.next_due[0] <= cycle:
            status = _issue_due(spec, state, cycle)
            if status != PLAYED:
                run["cycle"] = cycle
                return status

        due = state.core.next_due[0]
        if run["horizon"] > cycle and run["horizon"] >= due and dram_may_wait(spec, state, due):
            cycle = due
        else:
            run["cycle"] = cycle
            cycle = _end(spec, state, cycle)
            if run["needs_room"] != 0 and cycle != NEVER:
                run["cycle"] = cycle
                return NEEDS_ROOM
    return OVER


@inlined_step
def _begin(spec, state, cycle):
    """Phase 0 of `cycle`: fills, then the source."""
    if state.run[0]["next_answer"] <= cycle:
        deliver_due(spec, state, cycle)
    if source_due(spec, state) <= cycle:
        make_task(spec, state, cycle)


@inlined_step
def _issue_due(spec, state, cycle):
    """The cores that are due in `cycle` issue, and when the next one is due is found out; what became of the last."""
    next_due, soonest = state.core.next_due, NEVER
    next_due[0] = NEVER
    for core in range(spec.core.num_cores):
        if state.core.due[core] <= cycle:
            status = issue(spec, state, cycle, np.uint32(core))
            if status != PLAYED:
                next_due[0] = cycle
                return status
        soonest = min(soonest, state.core.due[core])
    next_due[0] = min(next_due[0], soonest)
    return PLAYED


@inlined_step
def _end(spec, state, cycle):
    """Phase 2 of `cycle` and the DRAM's clocks; returns the next cycle in which something can happen, or NEVER."""
    run = state.run[0]
    if run["next_lookup"] <= cycle:
        look_up_due(spec, state, cycle)
    due = state.core.next_due[0]
    later = play_dram(spec, state, max(cycle + 1, min(_next_event(spec, state), due)))
    run["horizon"] = min(_next_event(spec, state), run["pause"] - 1)
    return later


@inlined_step
def _next_event(spec, state):
    """Cycle of the first fill, lookup or task that is to come, as far as the DRAM has been played."""
    run = state.run[0]
    return min(min(run["next_answer"], run["next_lookup"]), source_due(spec, state))
