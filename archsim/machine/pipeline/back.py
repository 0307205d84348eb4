"""The back of a unit in the compiled pipeline: completes operations in the order in which they joined."""

from __future__ import annotations

from archsim.machine.pipeline import accesses, channels
from archsim.machine.pipeline.state import Machine, State
from archsim.model.cache.compiled_state import CLEAR, WRITE
from archsim.model.compiled import inlined_step, step
from archsim.model.unit import compiled as unit_model
from archsim.model.unit.compiled import NO_OPERATION
from archsim.model.unit.spec import Slot
from archsim.trace.records import Op


@inlined_step
def complete(spec: Machine, state: State, cycle, number):
    """Complete what can be completed in `cycle`."""
    unit = state.stages.units[number]
    while unit["oldest"] < unit["next"] and _completes(spec, state, cycle, number):
        unit["oldest"] += 1
        unit["last_move"] = cycle


@inlined_step
def _completes(spec, state, cycle, number):
    """Whether the oldest operation in flight completes in `cycle`."""
    unit = state.stages.units[number]
    oldest = unit_model.operation_at(state.stages, number, unit["oldest"])
    op = oldest["op"]
    if op == Op.LOAD or op == Op.CLEAR:
        return oldest["unanswered"] == 0 and oldest["address"] >= oldest["end"]
    if cycle < oldest["ready"]:
        return False
    if op == Op.STORE:
        return ask_for_lines(spec, state, cycle, number, unit["oldest"], WRITE)
    if op == Op.RELEASE:
        channels.release(state, cycle, state.stages.wiring[unit["first_pools"] + oldest["address"]])
        return True

    channel = state.stages.wiring[unit["first_outputs"] + oldest["address"]]
    if op == Op.EMIT:
        return channels.put(spec, state, cycle, channel, oldest["end"] - oldest["address"])
    channels.mark(spec, state, cycle, channel)
    return True


@step
def ask_for_lines(spec: Machine, state: State, cycle, number, position, kind):
    """Whether, with the free accesses of `cycle`, all lines of the operation at `position` are asked for."""
    unit = state.stages.units[number]
    operation = unit_model.operation_at(state.stages, number, position)
    is_write = kind == WRITE
    while operation["address"] < operation["end"] and unit["under_way"] < unit["outstanding"]:
        first = operation["address"]
        end = operation["end"]
        if kind != CLEAR:
            end = min((first | (unit["line_bytes"] - 1)) + 1, end)
        access = unit_model.begin_access(state.stages, number, NO_OPERATION if is_write else position)
        where = unit["memory"], first, end - 1
        accesses.ask(spec, state, cycle, number, access, where, kind)
        operation["address"] = end
        if is_write:
            unit["stores"] += 1
            unit["store_bytes"] += end - first
            continue
        operation["unanswered"] += 1
        if kind == CLEAR:
            unit["clears"] += 1
        else:
            unit["loads"] += 1
            unit["load_bytes"] += end - first
    return operation["address"] >= operation["end"]


@inlined_step
def hindrance(state: State, cycle, number):
    """Why the oldest operation in flight has not completed in `cycle`."""
    unit = state.stages.units[number]
    oldest = unit_model.operation_at(state.stages, number, unit["oldest"])
    if oldest["op"] == Op.LOAD or oldest["op"] == Op.CLEAR:
        return Slot.MEMORY
    if cycle < oldest["ready"]:
        return Slot.LATENCY
    if oldest["op"] == Op.STORE:
        return Slot.MEMORY
    channel = state.stages.wiring[unit["first_outputs"] + oldest["address"]]
    return Slot.DELAY_STREAM if channels.is_stream(state, channel) else Slot.OUTPUT
