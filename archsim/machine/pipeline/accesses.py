"""How units and delay streams of the compiled pipeline ask the memory, and how they notice that they are answered."""

from __future__ import annotations

from archsim.machine import memory, waits
from archsim.machine.pipeline.state import Machine, State
from archsim.machine.waits import IN_PARTS
from archsim.model.cache.compiled_state import CLEAR, Request
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.compiled import inlined_step, step
from archsim.model.core import compiled as core_model
from archsim.model.core import compiled_turns as turns
from archsim.model.unit import compiled as unit_model

NOBODY = -1


@inlined_step
def number_of(spec: Machine, requester, access):
    """The number of the requester's access among all."""
    return requester * spec.core.num_threads + access


@step
def ask(spec: Machine, state: State, cycle, requester, access, where, kind):
    """Access number `access` of the requester asks in `cycle`. `where`: the memory, first and last byte."""
    level, first, last = where
    number = number_of(spec, requester, access)
    if level != DRAM_PARENT:
        request = Request(first, last + 1 - first, kind, number)
        if state.cache.watched[level] and kind != CLEAR:
            memory.see(state, cycle, requester, request)
        memory.put(spec, state, cycle, level, requester, request)
        return
    begin = first >> spec.burst_shift
    bursts = (last >> spec.burst_shift) - begin + 1
    rank = requester - spec.core.num_cores
    start, num_bytes = begin << spec.burst_shift, bursts << spec.burst_shift
    request = Request(start, num_bytes, kind, number)
    if state.cache.watched[DRAM_PARENT]:
        memory.see(state, cycle, requester, request)
    memory.access_dram(spec, state, cycle, rank, bursts, request)


@inlined_step
def wake(state: State, cycle, requester):
    """Whether the requester has answered accesses in `cycle`."""
    core_model.wake_due(state.core, cycle, requester)
    owner = state.core.cores[requester]
    for word in range(owner["first_word"], owner["first_word"] + owner["num_words"]):
        if state.core.ready[word] != 0:
            return True
    return False


@inlined_step
def next_answered(spec: Machine, state: State, requester):
    """The number of an access of the requester that is answered and not yet dealt with, or NOBODY."""
    access = core_model.first_ready(state.core, requester, 0)
    if access == core_model.NO_THREAD:
        return NOBODY
    turns.park(state.core, number_of(spec, requester, access))
    return access


@step
def charge_wait(spec: Machine, state: State, cycle, unit, request):
    """The unit's cycles since it last moved and before `cycle` are charged to what a request waited for in them.

    `request`: number of the access among all, and the level that was asked, DRAM_PARENT for the DRAM.
    """
    since, (number, level) = state.stages.units[unit]["since"], request
    counts, reason = state.stages.waits[unit], state.core.threads[number]["reason"]
    if reason == IN_PARTS:
        level = level if level != DRAM_PARENT else len(spec.caches)
        waits.charge(spec, state, counts, (since, cycle), (number, level))
    else:
        counts[reason] += cycle - since
    unit_model.account(state.stages, cycle, unit)
