"""Fixed-function stages, compiled: the source of the cores' tasks, and what a unit of a pipeline remembers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.model.compiled import inlined_step, record, step
from archsim.model.unit.spec import Slot, StageSpec
from archsim.trace.records import Op


class SourceState(NamedTuple):
    """What the source remembers."""

    ready: np.ndarray  # [1] earliest core cycle at which it can make the next task


def new_source() -> SourceState:
    """A source that can make its first task in cycle 0."""
    return SourceState(np.zeros(1, np.int64))


@step
def start_interval(spec, state, cycle):
    """A task was made in `cycle`; the next one takes the interval."""
    state.ready[0] = cycle + spec.interval_cycles


NO_OPERATION = -1
NO_ACCESS = -1
_WIRED = ("inputs", "outputs", "pools")
_PLAIN = tuple(name for name in StageSpec._fields if name not in _WIRED)
_UNIT_FIELDS = (
    *_PLAIN,
    *(f"first_{name}" for name in _WIRED),  # where they begin in `wiring`
    *(f"num_{name}" for name in _WIRED),
    "cursor",  # current record among the loaded ones
    "end",  # of the unit's loaded records
    "is_computed",  # whether the steps before the record's operation were begun
    "busy_until",  # cycle in which they end
    "began",  # cycle in which the task began
    "is_opening",  # whether the task has only taken items and tokens
    "is_loading",  # whether the front has not asked for all lines of the youngest operation
    "oldest",  # number of the oldest operation in flight
    "next",  # number of the next operation
    "under_way",  # accesses
    "due",  # next cycle in which the unit has something to do by itself, or NEVER
    "roused",  # last cycle in which something that it waits for may have happened
    "slot",  # what the front does
    "awaits",  # access of a delay stream that it waits for, among all accesses, or NO_ACCESS
    "since",  # cycle since when; those before are accounted for
    "last_move",  # last cycle in which something was done
    "tasks",
    "loads",
    "stores",
    "clears",
    "load_bytes",
    "store_bytes",
)
UNIT = record(*_UNIT_FIELDS)
# An operation between front and back: `address` and `end` bound what is to be asked for, `unanswered` counts lines.
OPERATION = record("op", "ready", "address", "end", "unanswered")


class StagesState(NamedTuple):
    """U units, at most A accesses under way each."""

    units: np.ndarray  # UNIT [U]
    wiring: np.ndarray  # [...] channels and pools of all units
    in_flight: np.ndarray  # OPERATION [U, capacity] rings, capacity a power of two
    free: np.ndarray  # [U, A] stacks of free accesses; the first A - `under_way` are free
    operation: np.ndarray  # [U, A] number of the LOAD that an access is part of, or NO_OPERATION
    asked: np.ndarray  # [U, A] number of the access among those of its unit
    slots: np.ndarray  # [U, Slot] cycles by what the front did
    waits: np.ndarray  # [U, STALL_MEMORY + causes] cycles of Slot.MEMORY by what was waited for


def new_stages(specs: Sequence[StageSpec], num_reasons: int) -> StagesState:
    """All idle, without a record."""
    units = np.zeros(len(specs), UNIT)
    wiring: list[int] = []
    for number, spec in enumerate(specs):
        for name in _PLAIN:
            units[number][name] = getattr(spec, name)
        for name in _WIRED:
            units[number][f"first_{name}"], units[number][f"num_{name}"] = (
                len(wiring),
                len(getattr(spec, name)),
            )
            wiring += getattr(spec, name)
    units["is_opening"] = 1
    units["slot"] = Slot.NO_WORK
    units["awaits"] = NO_ACCESS
    capacity = 1 << max((spec.in_flight for spec in specs), default=0).bit_length()
    most = max((spec.outstanding for spec in specs), default=1)
    return StagesState(
        units=units,
        wiring=np.array([*wiring, 0], np.int64),
        in_flight=np.zeros((len(specs), capacity), OPERATION),
        free=np.tile(np.arange(most), (len(specs), 1)),
        operation=np.full((len(specs), most), NO_OPERATION),
        asked=np.zeros((len(specs), most), np.int64),
        slots=np.zeros((len(specs), len(Slot)), np.int64),
        waits=np.zeros((len(specs), num_reasons), np.int64),
    )


@inlined_step
def account(state, cycle, number):
    """The cycles before `cycle` went as the last look at the unit said."""
    unit = state.units[number]
    state.slots[number, unit["slot"]] += cycle - unit["since"]
    unit["since"] = cycle


@inlined_step
def is_held_back_by_all(state, number):
    """Of a unit whose front memory holds back: whether all of the oldest operation has to come, not any access."""
    unit = state.units[number]
    if unit["is_loading"] != 0:
        return False
    op = operation_at(state, number, unit["oldest"])["op"]
    return op == Op.LOAD or op == Op.CLEAR


@inlined_step
def operation_at(state, number, position):
    """The operation in flight that was the `position`-th to join."""
    return state.in_flight[number, position & (state.in_flight.shape[1] - 1)]


@inlined_step
def is_full(unit):
    """Whether no operation can join."""
    return unit["next"] - unit["oldest"] >= unit["in_flight"]


@inlined_step
def join(state, cycle, number, work):
    """The record's operation is in flight from `cycle` on."""
    unit = state.units[number]
    operation = operation_at(state, number, unit["next"])
    operation["op"] = work["op"]
    operation["ready"] = cycle + unit["latency_cycles"]
    operation["address"] = work["address"]
    operation["end"] = work["address"] + work["bytes"]
    operation["unanswered"] = 0
    unit["next"] += 1


@inlined_step
def begin_access(state, number, position):
    """A free access begins, for the operation at `position` if that is told of the answer; returns its number."""
    unit = state.units[number]
    access = state.free[number, unit["outstanding"] - unit["under_way"] - 1]
    unit["under_way"] += 1
    state.operation[number, access] = position
    state.asked[number, access] = unit["loads"] + unit["stores"] + unit["clears"]
    return access


@inlined_step
def end_access(state, cycle, number, access):
    """The access is answered in `cycle`."""
    unit = state.units[number]
    unit["under_way"] -= 1
    unit["last_move"] = cycle
    state.free[number, unit["outstanding"] - unit["under_way"] - 1] = access
    position = state.operation[number, access]
    if position != NO_OPERATION:
        operation_at(state, number, position)["unanswered"] -= 1


@inlined_step
def rouse(state, cycle, number):
    """The unit looks again in `cycle`, the next one."""
    state.units[number]["roused"] = cycle


@inlined_step
def due_by_itself(state, cycle, number, front_due):
    """When the unit must look again after `cycle` even if nobody rouses it."""
    unit = state.units[number]
    if unit["oldest"] == unit["next"]:
        return front_due
    ready = operation_at(state, number, unit["oldest"])["ready"]
    return min(front_due, ready) if ready > cycle else front_due
