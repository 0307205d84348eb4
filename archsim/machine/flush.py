"""Writing back what is dirty in the caches when a run of a compiled machine, of cores or of stages, is over."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from archsim.jit import njit
from archsim.machine.memory import send_victim

State = TypeVar("State", bound=Any)


def next_dirty(machine: Any, state: Any, unflushed: list[int]) -> int | None:
    """The first of the caches that has something to write back; it and those before it are taken out."""
    while unflushed:
        cache = unflushed.pop(0)
        first = machine.caches[cache]["first_set"]
        ways = state.cache.ways[first : first + machine.caches[cache]["set_mask"] + 1]
        if np.any(ways["dirty"]):
            return cache
    return None


def flushed(machine: Any, state: State, cache: int, with_room: Callable[[State], State]) -> State:
    """The state with all on its way that the cache writes back, sent in the first cycle in which nothing else is."""
    cycle = drained_cycles(state.run, machine.core.period_ticks, machine.dram.period_ticks)
    one, place = machine.caches[cache], 0
    state.run[0]["cycle"] = cycle
    while place < (one["set_mask"] + 1) * one["num_ways"]:
        place = _send_dirty(machine, state, cycle, cache, place)
        state = with_room(state)
    return state


def drained_cycles(run: np.ndarray, core_period: int, dram_period: int) -> int:
    """The cycle of the last thing that happened in a run, rounded up."""
    last_tick = int(run[0]["last_clock"]) * int(dram_period)
    return max(int(run[0]["cycle"]), -(-last_tick // int(core_period)))


@njit(error_model="numpy", _nrt=False, no_cfunc_wrapper=True)
def _send_dirty(spec, state, cycle, cache, place):
    """Send the dirty sectors of a cache in `cycle`, from a place (set by set, way by way) on, while there is room.

    Returns the place to go on with: the number of places when all are sent.
    """
    one, owner = spec.caches[cache], state.cache.caches[cache]
    num_ways = one["num_ways"]
    num_places = (one["set_mask"] + 1) * num_ways
    while place < num_places and state.run[0]["needs_room"] == 0:
        row, number = one["first_set"] + place // num_ways, place % num_ways
        way, tag = state.cache.ways[row, number], state.cache.tags[row, number]
        if way["dirty"] != 0:
            owner["victim"], owner["victim_dirty"] = max(tag, ~tag), way["dirty"]
            send_victim(spec, state, cycle + one["hit_cycles"], cache)
            way["dirty"] = 0
        place += 1
    return place
