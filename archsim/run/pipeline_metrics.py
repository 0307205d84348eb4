"""Counters of a pipeline as named statistics, and the laws they obey."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.machine.build import PhaseMachine
from archsim.machine.pipeline.build import PipelineMachine
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.spec import MachineSpec
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks.spec import LocksSpec
from archsim.model.unit.spec import NO_MEMORY, Slot, UnitSpec
from archsim.run.measure import Measure, measured, percent, ratio
from archsim.run.metrics import equal, memory_statistics, phase_latencies
from archsim.run.result import Check, Statistic
from archsim.run.stall_metrics import stall_statistics


class PipelineView(NamedTuple):
    """A pipeline that was played, or one of its components by number."""

    machine: PipelineMachine
    counters: PipelineCounters
    number: int = 0

    def own(self, counter: str) -> int:
        """The component's value of a counter."""
        return int(getattr(self.counters, counter)[self.number])

    def slot_percent(self, slot: Slot) -> float:
        """Share of the unit's cycles in which its front did this."""
        return percent(self.counters.unit_slots[self.number, slot], self.counters.cycles)


RUN = [
    Measure(
        "cycles", "cycles", "Cycles until no unit had anything left to do.", lambda view: view.counters.cycles
    ),
    Measure(
        "drained_cycles",
        "cycles",
        "Cycles, rounded up, until nothing was on its way in caches and DRAM any more.",
        lambda view: view.counters.memory.drained_cycles,
    ),
    Measure(
        "frames_per_second",
        "frames/s",
        "Clock frequency of the units over cycles: the rate if a frame were this alone.",
        lambda view: ratio(view.machine.tick_hertz / view.machine.spec.period_ticks, view.counters.cycles),
    ),
]

UNITS = [
    Measure("tasks", "tasks", "Tasks ended.", lambda view: view.own("unit_tasks")),
    Measure(
        "busy_percent",
        "%",
        "Cycles in which the unit computed, or was within the interval of its task.",
        lambda view: view.slot_percent(Slot.BUSY),
    ),
    Measure(
        "stall.no_work_percent",
        "%",
        "Cycles in which it waited for an item, or had done all its tasks.",
        lambda view: view.slot_percent(Slot.NO_WORK),
    ),
    Measure(
        "stall.memory_percent",
        "%",
        "Cycles in which it waited for a free access or a delay stream's transfer, or a LOAD or STORE held it back.",
        lambda view: view.slot_percent(Slot.MEMORY),
    ),
    Measure(
        "stall.output_percent",
        "%",
        "Cycles in which a full fifo held it back.",
        lambda view: view.slot_percent(Slot.OUTPUT),
    ),
    Measure(
        "stall.delay_stream_percent",
        "%",
        "Cycles in which a full delay stream held it back.",
        lambda view: view.slot_percent(Slot.DELAY_STREAM),
    ),
    Measure(
        "stall.latency_percent",
        "%",
        "Cycles in which an operation on its way through the unit held it back.",
        lambda view: view.slot_percent(Slot.LATENCY),
    ),
    Measure(
        "stall.pool_percent",
        "%",
        "Cycles in which it waited for a token.",
        lambda view: view.slot_percent(Slot.POOL),
    ),
    Measure("loads", "lines", "Lines asked for by LOADs.", lambda view: view.own("unit_loads")),
    Measure("stores", "lines", "Lines asked for by STOREs.", lambda view: view.own("unit_stores")),
    Measure("clears", "requests", "CLEARs asked for.", lambda view: view.own("unit_clears")),
    Measure("load_bytes", "bytes", "Bytes that the LOADs named.", lambda view: view.own("unit_load_bytes")),
    Measure(
        "store_bytes", "bytes", "Bytes that the STOREs named.", lambda view: view.own("unit_store_bytes")
    ),
]

CHANNELS = [
    Measure(
        "items",
        "items",
        "Items that went through the fifo or delay stream.",
        lambda view: view.own("channel_taken"),
    ),
    Measure(
        "peak",
        "items or bytes",
        "Most items that a fifo, most bytes that a delay stream held at once.",
        lambda view: view.own("channel_peak"),
    ),
    Measure(
        "fill_percent",
        "%",
        "Share of the fifo's entries, or of the delay stream's bytes, that was held, mean over all cycles.",
        lambda view: percent(
            view.own("channel_stayed"), view.counters.cycles * view.machine.spec.capacity(view.number)
        ),
    ),
]

STREAMS = [
    Measure("bytes", "bytes", "Bytes of the items.", lambda view: view.own("stream_bytes")),
    Measure(
        "writes", "requests", "Requests to the DRAM that wrote them.", lambda view: view.own("stream_writes")
    ),
    Measure("reads", "requests", "Requests that read them back.", lambda view: view.own("stream_reads")),
    Measure("marks", "markers", "MARK operations.", lambda view: view.own("stream_marks")),
    Measure(
        "early",
        "items",
        "Items released because the ring was full, before their marker.",
        lambda view: view.own("stream_early"),
    ),
]

POOLS = [
    Measure("acquired", "tokens", "Tokens acquired.", lambda view: view.own("pool_acquired")),
    Measure("peak", "tokens", "Most tokens held at once.", lambda view: view.own("pool_peak")),
]


def pipeline_statistics(phase: str, machine: PipelineMachine, counters: PipelineCounters) -> list[Statistic]:
    """Every counter of a pipeline and the ratios made of them, named `phase.component.what`."""
    found = measured(phase, RUN, PipelineView(machine, counters))
    num_fifos = len(machine.spec.fifos)
    tables = [
        (machine.units, UNITS),
        (machine.channels, CHANNELS),
        (machine.channels[num_fifos:], STREAMS),
        (machine.pools, POOLS),
    ]
    for names, table in tables:
        for number, name in enumerate(names):
            found += measured(f"{phase}.{name}", table, PipelineView(machine, counters, number))
    for number, name in enumerate(machine.units):
        levels, waits = _levels_below(machine, number), counters.unit_waits[number]
        found += stall_statistics(f"{phase}.{name}", levels, waits, counters.cycles)
    return found + memory_statistics(phase, without_cores(machine), counters.memory)


def pipeline_latencies(
    phase: str, machine: PipelineMachine, counters: PipelineCounters
) -> dict[str, np.ndarray]:
    """Requests by class of latency, for every cache and the DRAM."""
    return phase_latencies(phase, without_cores(machine), counters.memory)


def _levels_below(machine: PipelineMachine, unit: int) -> dict[str, list[int]]:
    """The caches that a unit's accesses may pass, by name, and the DRAM; nothing for a unit that waits for neither."""
    spec, stage = machine.spec, machine.spec.units[unit]
    level, has_stream = stage.memory, any(channel >= len(spec.fifos) for channel in stage.inputs)
    if level == NO_MEMORY:
        return {"dram": [len(spec.caches)]} if has_stream else {}
    found = {}
    while level != DRAM_PARENT:
        found[machine.caches[level]] = [level]
        level = spec.caches[level].parent
    return {**found, "dram": [len(spec.caches)]}


def without_cores(machine: PipelineMachine) -> PhaseMachine:
    """The caches and the DRAM of a pipeline as a machine of no cores."""
    spec = machine.spec
    nobody = CoreSpec(0, 1, spec.period_ticks, int(TaskOrder.FIRST_FREE))
    memory = MachineSpec(nobody, (), LocksSpec(0), UnitSpec(0), FifoSpec(1), spec.caches, spec.dram)
    return PhaseMachine(memory, machine.caches, machine.tick_hertz, machine.dram_bytes)


def pipeline_checks(phase: str, machine: PipelineMachine, counters: PipelineCounters) -> list[Check]:
    """The conservation laws of a pipeline."""
    spec, memory = machine.spec, counters.memory
    users = np.array([unit.memory for unit in spec.units], np.int64)
    direct = users == DRAM_PARENT
    last = [k for k, cache in enumerate(spec.caches) if cache.parent == DRAM_PARENT]
    fetched = memory.cache_fetches[last].sum()
    writes_out = memory.cache_writebacks_out + memory.cache_writethroughs_out
    evicted = writes_out[last].sum()
    read = counters.unit_loads[direct].sum() + counters.stream_reads.sum() + fetched
    written = counters.unit_stores[direct].sum() + counters.stream_writes.sum() + evicted
    requests = memory.dram_reads + memory.dram_writes
    classified = memory.dram_row_hits + memory.dram_row_misses + memory.dram_row_conflicts
    outcomes = memory.cache_hits + memory.cache_merges + memory.cache_misses
    lookups = memory.cache_reads + memory.cache_writes + memory.cache_writebacks_in
    answered = memory.cache_reads + memory.cache_writes + memory.cache_clears
    laws = [
        ("slots", counters.unit_slots.sum(axis=1), np.full(len(spec.units), counters.cycles)),
        ("waits for memory", counters.unit_waits.sum(axis=1), counters.unit_slots[:, Slot.MEMORY]),
        ("items", counters.channel_put, counters.channel_taken),
        ("tokens", counters.pool_acquired, counters.pool_released),
        ("reads reach the DRAM", read, memory.dram_reads.sum() + memory.dram_forwarded.sum()),
        ("writes reach the DRAM", written, memory.dram_writes.sum()),
        ("row outcomes", requests, classified),
        ("lookups", lookups, outcomes),
        ("latencies at caches", memory.latencies[:-1].sum(axis=1), answered),
        ("latencies at the DRAM", memory.latencies[-1].sum(), read + written - evicted),
    ]
    for k in range(len(spec.caches)):
        children = [child for child, cache in enumerate(spec.caches) if cache.parent == k]
        loads = counters.unit_loads[users == k].sum() + memory.cache_fetches[children].sum()
        laws.append((f"reads of cache {machine.caches[k]}", loads, memory.cache_reads[k]))
        stores = counters.unit_stores[users == k].sum()
        laws.append((f"writes of cache {machine.caches[k]}", stores, memory.cache_writes[k]))
        clears = counters.unit_clears[users == k].sum()
        laws.append((f"clears of cache {machine.caches[k]}", clears, memory.cache_clears[k]))
        evicted = writes_out[children].sum()
        laws.append((f"write-backs into cache {machine.caches[k]}", evicted, memory.cache_writebacks_in[k]))
    return [equal(f"{phase}: {name}", left, right) for name, left, right in laws]
