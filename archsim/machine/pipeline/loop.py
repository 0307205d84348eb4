"""The main loop of the compiled pipeline: the phases of one cycle, and the way to the next one that matters.

A unit or delay stream is looked at in a cycle only if something that it waits for may have happened. Looking too early
does no harm.
"""

from __future__ import annotations

from archsim.jit import njit
from archsim.machine.dram_side import play_dram
from archsim.machine.memory import deliver_due, look_up_due
from archsim.machine.pipeline import accesses, back, front
from archsim.machine.pipeline.channels import rouse_stream
from archsim.machine.pipeline.front import NEEDS_WORK
from archsim.machine.pipeline.state import Machine, State
from archsim.model.cache.compiled_state import READ, WRITE
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.compiled import NEVER, inlined_step, step
from archsim.model.core.compiled import next_wake
from archsim.model.delay_stream import compiled as stream_model
from archsim.model.delay_stream.compiled import READS, WRITES
from archsim.model.unit import compiled as unit_model
from archsim.model.unit.compiled import NO_ACCESS
from archsim.model.unit.spec import Slot

OVER, WORK_WANTED, NEEDS_ROOM, PAUSED = range(4)  # why `play` returns


@njit(error_model="numpy", _nrt=False, no_cfunc_wrapper=True)
def play(spec: Machine, state: State):
    """Play until the work is over or the caller must help; the status says which."""
    run = state.run[0]
    cycle, first_unit = run["cycle"], run["next_unit"]
    while cycle != NEVER:
        run["cycle"] = cycle
        if run["pause"] <= cycle:
            run["next_unit"] = 0
            return PAUSED
        if run["next_answer"] <= cycle:
            deliver_due(spec, state, cycle)
        for number in range(first_unit, len(state.stages.units)):
            if not _look_at_unit(spec, state, cycle, number):
                run["next_unit"] = number
                return WORK_WANTED
        first_unit = 0
        for number in range(len(state.stream_roused)):
            _look_at_stream(spec, state, cycle, number)
        if run["next_lookup"] <= cycle:
            look_up_due(spec, state, cycle)

        cycle = play_dram(spec, state, next_wake(state.core, cycle, _next_due(state, cycle)))
        if run["needs_room"] != 0 and cycle != NEVER:
            run["cycle"], run["next_unit"] = cycle, 0
            return NEEDS_ROOM
    return OVER


@inlined_step
def _next_due(state, cycle):
    """First cycle after `cycle` in which a unit, a delay stream or a cache has something to do, as far as is known."""
    due = min(state.run[0]["next_answer"], state.run[0]["next_lookup"])
    if state.work[0]["is_over"] != 0 and _are_done(state.stages.units):
        return due
    for number in range(len(state.stages.units)):
        unit = state.stages.units[number]
        due = min(due, unit["roused"] if unit["roused"] > cycle else unit["due"])
    for number in range(len(state.stream_roused)):
        due = cycle + 1 if state.stream_roused[number] > cycle else due
    return due


@step
def _are_done(units):
    """Whether the units have done all that was loaded."""
    for number in range(len(units)):
        unit = units[number]
        if unit["cursor"] < unit["end"] or unit["oldest"] < unit["next"] or unit["under_way"] > 0:
            return False
    return True


@inlined_step
def _look_at_unit(spec, state, cycle, number):
    """Let the unit do what `cycle` allows, if it may have something to do; False if it needs its next task first."""
    unit = state.stages.units[number]
    is_answered = unit["under_way"] > 0 and accesses.wake(state, cycle, number)
    if is_answered or unit["due"] <= cycle or unit["roused"] >= cycle:
        return _play_unit(spec, state, cycle, number)
    return True


@inlined_step
def _play_unit(spec, state, cycle, number):
    """Phase 1 of `cycle` for the unit; False if it needs its next task first."""
    stages = state.stages
    if stages.units[number]["slot"] != Slot.MEMORY:
        unit_model.account(stages, cycle, number)
    _end_accesses(spec, state, cycle, number)
    back.complete(spec, state, cycle, number)
    slot, front_due = front.go_on(spec, state, cycle, number)
    if slot == NEEDS_WORK:
        stages.units[number]["due"] = cycle
        return False
    stages.units[number]["slot"] = slot
    stages.units[number]["due"] = unit_model.due_by_itself(stages, cycle, number, front_due)
    return True


@step
def _end_accesses(spec, state, cycle, number):
    """The unit notes its accesses that are answered in `cycle`; one of them may end a wait for memory."""
    stages, unit = state.stages, state.stages.units[number]
    is_waiting = unit["slot"] == Slot.MEMORY and unit["awaits"] == NO_ACCESS
    waits_for_all = is_waiting and unit_model.is_held_back_by_all(stages, number)
    ending = accesses.NOBODY
    while True:
        access = accesses.next_answered(spec, state, number)
        if access == accesses.NOBODY:
            break
        unit_model.end_access(stages, cycle, number, access)
        if waits_for_all and stages.operation[number, access] != unit["oldest"]:
            continue
        is_later = ending != accesses.NOBODY and stages.asked[number, access] > stages.asked[number, ending]
        if ending == accesses.NOBODY or is_later == waits_for_all:
            ending = access
    if waits_for_all and unit_model.operation_at(stages, number, unit["oldest"])["unanswered"] > 0:
        ending = accesses.NOBODY
    if is_waiting and ending != accesses.NOBODY:
        request = accesses.number_of(spec, number, ending), unit["memory"]
        accesses.charge_wait(spec, state, cycle, number, request)


@inlined_step
def _look_at_stream(spec, state, cycle, number):
    """Let the delay stream do what `cycle` allows, if it may have something to do."""
    requester = len(state.stages.units) + number
    is_answered = accesses.wake(state, cycle, requester)
    if is_answered or state.stream_roused[number] >= cycle:
        _play_stream(spec, state, cycle, number)


@step
def _play_stream(spec, state, cycle, number):
    """Phase 1 of `cycle` for the delay stream: notes what is written and read, sends a write, asks for a read."""
    streams, stream = state.streams, state.streams.streams[number]
    slots, requester = streams.under_way.shape[2], len(state.stages.units) + number
    consumer = spec.consumers[len(state.pipes.pipes) + number]
    while True:
        access = accesses.next_answered(spec, state, requester)
        if access == accesses.NOBODY:
            break
        stream_model.finish(streams, cycle, number, access // slots, access % slots)
        request = accesses.number_of(spec, requester, access), DRAM_PARENT
        if state.stages.units[consumer]["awaits"] == request[0]:
            accesses.charge_wait(spec, state, cycle + 1, consumer, request)
        rouse_stream(state, cycle + 1, number)
        unit_model.rouse(state.stages, cycle + 1, consumer)

    _transfer(
        spec, state, cycle, number, WRITES, stream["sent"], stream_model.write_end(streams, cycle, number)
    )
    _transfer(
        spec, state, cycle, number, READS, stream["asked"], stream_model.read_end(streams, cycle, number)
    )


@step
def _transfer(spec, state, cycle, number, direction, begin, end):
    """Ask the DRAM in `cycle` to write or read the bytes from `begin` to `end` of the delay stream, if any."""
    if end == begin:
        return
    streams, stream = state.streams, state.streams.streams[number]
    slot = stream_model.begin(streams, number, direction, end)
    first = stream["base"] + begin % stream["ring_bytes"]
    where = DRAM_PARENT, first, first + end - begin - 1
    access = direction * streams.under_way.shape[2] + slot
    kind = WRITE if direction == WRITES else READ
    accesses.ask(spec, state, cycle, len(state.stages.units) + number, access, where, kind)
    rouse_stream(state, cycle + 1, number)
    consumer = spec.consumers[len(state.pipes.pipes) + number]
    if state.stages.units[consumer]["slot"] == Slot.NO_WORK:
        unit_model.rouse(state.stages, cycle + 1, consumer)
