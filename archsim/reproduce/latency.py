"""Unloaded latencies, measured by playing single accesses on a machine."""

from __future__ import annotations

import math

import numpy as np

from archsim.machine.reference import simulate
from archsim.machine.spec import MachineSpec
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import whole

_ACCESS_BYTES = 16


def minimum_miss_cycles(spec: MachineSpec, core_cache: int) -> dict[str, float]:
    """Cycles spent below the first (`L1`) and below its next level (`L2`) by the fastest possible miss.

    L1: the line is in the L2. L2: the DRAM row is open, nothing else is on its way, and the request meets the memory
    clock as well as it can ([Johnson04] table 2: "assumes a DRAM page hit and no contention").
    """
    second = spec.caches[core_cache].parent
    line, parent_line = spec.caches[core_cache].line_bytes, spec.caches[second].line_bytes
    if parent_line <= line:
        raise ValueError("the measurement needs L2 lines that hold several L1 lines")
    return {
        "L1": _added_cycles(spec, core_cache, line, 0),
        "L2": min(_added_cycles(spec, second, _same_row(spec), wait) for wait in range(_alignments(spec))),
    }


def _added_cycles(spec: MachineSpec, cache: int, address: int, wait: int) -> float:
    """Cycles below `cache` that a load of `address` takes, issued `wait` instructions after a load of address 0."""
    first = simulate(spec, whole(_loads([(0, 0)]))).cache_fetch_ticks[cache]
    both = simulate(spec, whole(_loads([(0, 0), (wait, address)]))).cache_fetch_ticks[cache]
    return int(both - first) / spec.core.period_ticks


def _loads(accesses: list[tuple[int, int]]) -> Tasks:
    """One task of (instructions before, address) loads."""
    records = [(address, compute, _ACCESS_BYTES, Op.LOAD) for compute, address in accesses]
    records.append((0, 0, 0, Op.END))
    return Tasks(np.array([0, len(records)], np.int64), np.array(records, RECORD))


def _same_row(spec: MachineSpec) -> int:
    """The address of the line that follows line 0 in its DRAM row."""
    fields = (spec.dram.channel, spec.dram.bank, spec.dram.row)
    taken = sum(((1 << field.bits) - 1) << field.shift for field in fields)
    address = max(cache.line_bytes for cache in spec.caches)
    while address & taken:
        address *= 2
    return address


def _alignments(spec: MachineSpec) -> int:
    """Core edges after which core and memory clock meet again."""
    core, memory = spec.core.period_ticks, spec.dram.period_ticks
    return math.lcm(core, memory) // core
