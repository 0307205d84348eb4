"""The front of a unit in the compiled pipeline: goes through the unit's records in order."""

from __future__ import annotations

from archsim.machine.pipeline import channels
from archsim.machine.pipeline.back import ask_for_lines, hindrance
from archsim.machine.pipeline.state import Machine, State
from archsim.model.cache.compiled_state import CLEAR, READ
from archsim.model.compiled import NEVER, inlined_step, step
from archsim.model.pool import compiled as pool_model
from archsim.model.unit import compiled as unit_model
from archsim.model.unit.compiled import NO_ACCESS
from archsim.model.unit.spec import Slot
from archsim.trace.records import Op

NEEDS_WORK = len(Slot)  # instead of a slot: the unit's next task must be loaded
_DONE = -1  # instead of a slot: the operation is done


@inlined_step
def go_on(spec: Machine, state: State, cycle, number):
    """Go on as far as the front can; returns what it does in `cycle`, and when it goes on by itself, or NEVER."""
    unit = state.stages.units[number]
    unit["awaits"] = NO_ACCESS
    while unit["cursor"] < unit["end"]:
        if cycle < unit["busy_until"]:
            return Slot.BUSY, unit["busy_until"]
        work = state.records[unit["cursor"]]
        if unit["is_computed"] == 0:
            unit["is_computed"] = 1
            if work["compute"] > 0:
                unit["is_opening"] = 0
                unit["busy_until"] = cycle + (work["compute"] + unit["lanes"] - 1) // unit["lanes"]
                continue

        slot = _operate(spec, state, cycle, number, work)
        if slot == Slot.BUSY:
            return slot, unit["began"] + unit["interval_cycles"]
        if slot != _DONE:
            return slot, NEVER
        unit["cursor"] += 1
        unit["is_computed"] = 0
        unit["last_move"] = cycle
    if state.work[0]["is_over"] == 0 and _wants_work(spec, state, cycle, number):
        return NEEDS_WORK, NEVER
    return Slot.NO_WORK, NEVER


@step
def _wants_work(spec, state, cycle, number):
    """Whether a unit that has no task must know its next one: it is a source, or an item is there or on its way."""
    unit = state.stages.units[number]
    for i in range(unit["num_inputs"]):
        channel = state.stages.wiring[unit["first_inputs"] + i]
        if channels.has_item(state, cycle, channel):
            return True
        if channels.coming(spec, state, cycle, channel) != NO_ACCESS:
            return True
    return unit["num_inputs"] == 0


@inlined_step
def _operate(spec, state, cycle, number, work):
    """Do the operation of the record in `cycle`; returns _DONE, or what the front does instead of going on."""
    unit, op = state.stages.units[number], work["op"]
    if op == Op.END:
        return _end(unit, cycle)
    if op == Op.TAKE:
        channel = state.stages.wiring[unit["first_inputs"] + work["address"]]
        if not channels.has_item(state, cycle, channel):
            unit["awaits"] = channels.coming(spec, state, cycle, channel)
            return Slot.NO_WORK if unit["awaits"] == NO_ACCESS else Slot.MEMORY
        channels.take(spec, state, cycle, channel)
        return _opened(unit, cycle)
    if op == Op.ACQUIRE:
        pool = state.stages.wiring[unit["first_pools"] + work["address"]]
        return _opened(unit, cycle) if pool_model.acquire(state.pools, cycle, pool) else Slot.POOL

    unit["is_opening"] = 0
    if unit["is_loading"] == 0:
        if unit_model.is_full(unit):
            return hindrance(state, cycle, number)
        unit_model.join(state.stages, cycle, number, work)
    if op == Op.LOAD or op == Op.CLEAR:
        unit["is_loading"] = 1
        kind = READ if op == Op.LOAD else CLEAR
        if not ask_for_lines(spec, state, cycle, number, unit["next"] - 1, kind):
            return Slot.MEMORY
        unit["is_loading"] = 0
    return _DONE


@inlined_step
def _end(unit, cycle):
    """The task ends, if its interval is over."""
    if cycle < unit["began"] + unit["interval_cycles"]:
        return Slot.BUSY
    unit["tasks"] += 1
    unit["began"] = cycle
    unit["is_opening"] = 1
    return _DONE


@inlined_step
def _opened(unit, cycle):
    """An item or a token was taken; a task that has only done so begins now."""
    if unit["is_opening"] != 0:
        unit["began"] = cycle
    return _DONE
