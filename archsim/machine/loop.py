"""The main loop of the compiled machine: the phases of one core cycle, and the way to the next one that matters.

Time is counted in core cycles. The order of what meets in one cycle is README.md's: fills, source, issue, lookups;
then the DRAM plays the memory clocks that lie before the next cycle visited.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import njit
from archsim.machine.issue import BAD_UNLOCK, ISSUED, NEEDS_TASKS, issue, make_task, source_due
from archsim.machine.memory import deliver_due, look_up_due, play_dram
from archsim.machine.state import Machine, State
from archsim.model.compiled import NEVER, inlined_step
from archsim.model.core.compiled import next_wake

OVER, NEEDS_ROOM, PAUSED = (
    BAD_UNLOCK + n for n in (1, 2, 3)
)  # why `play` returns, besides NEEDS_TASKS, BAD_UNLOCK

__all__ = ["BAD_UNLOCK", "NEEDS_ROOM", "NEEDS_TASKS", "OVER", "PAUSED", "play"]


@njit(error_model="numpy", _nrt=False, no_cfunc_wrapper=True)
def play(spec: Machine, state: State):
    """Play until the work is over or the caller must help; the status says which."""
    run = state.run[0]
    cycle, first_core = run["cycle"], run["next_core"]
    while cycle != NEVER:
        if run["horizon"] <= cycle:
            if run["pause"] <= cycle:
                run["cycle"], run["next_core"] = cycle, 0
                return PAUSED
            _begin(spec, state, cycle)
        issued = first_core
        for core in range(first_core, spec.core.num_cores):
            status = issue(spec, state, cycle, np.uint32(core))
            if status > ISSUED:
                run["cycle"], run["next_core"] = cycle, core
                return status
            issued |= status
        first_core = 0

        if issued != 0 and run["horizon"] > cycle:
            cycle += 1
        else:
            run["cycle"] = cycle
            cycle = _end(spec, state, cycle, issued != 0)
            if run["needs_room"] != 0 and cycle != NEVER:
                run["cycle"], run["next_core"] = cycle, 0
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
def _end(spec, state, cycle, any_issue):
    """Phase 2 of `cycle` and the DRAM's clocks; returns the next cycle in which something can happen, or NEVER."""
    run = state.run[0]
    if run["next_lookup"] <= cycle:
        look_up_due(spec, state, cycle)

    limit = cycle + 1
    if not any_issue:
        limit = max(limit, _next_event(spec, state))
        limit = next_wake(state.core, cycle, limit)
    later = play_dram(spec, state, limit)
    dram_ticks = state.dram.next_due[0] * spec.dram.period_ticks
    run["horizon"] = min(min(_next_event(spec, state), run["pause"]), dram_ticks // spec.core.period_ticks)
    return later


@inlined_step
def _next_event(spec, state):
    """Cycle of the first fill, lookup or task that is to come, as far as the DRAM has been played."""
    run = state.run[0]
    return min(min(run["next_answer"], run["next_lookup"]), source_due(spec, state))
