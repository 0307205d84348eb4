"""From a machine's description to the numbers that a phase is played on."""

from __future__ import annotations

from typing import Any, NamedTuple

from archsim.machine.spec import MachineSpec
from archsim.model.cache.spec import DRAM_PARENT, CacheSpec
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.dram.spec import AddressField, DramSpec, DramTiming, Scheduler
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks.spec import LocksSpec
from archsim.model.unit.spec import UnitSpec
from archsim.units import clock_periods


class PhaseMachine(NamedTuple):
    """The part of a machine that plays one phase."""

    spec: MachineSpec
    core_name: str
    cache_names: tuple[str, ...]  # [num_caches] component of each cache; private ones repeat their name
    tick_hertz: int


def phase_machine(machine: Any, role: str) -> PhaseMachine:
    """The components reachable from the cores that play `role`, of a checked MachineConfig."""
    parts = machine.components
    hertz = {name: int(clock) for name, clock in machine.clocks.items()}
    periods = clock_periods(hertz)
    core_name = getattr(machine.roles, role)
    core = parts[core_name]
    caches, names, core_cache = _caches(parts, core)
    source, fifo = _supply(parts, core)
    dram = parts[_dram_name(parts, core.memory)]
    spec = MachineSpec(
        CoreSpec(core.count, core.threads, periods[core.clock], _task_order(core)),
        core_cache,
        LocksSpec(parts[core.locks].count if core.locks else 0),
        source,
        fifo,
        caches,
        _dram(dram, caches[-1].line_bytes, periods[dram.clock]),
    )
    return PhaseMachine(spec, core_name, names, hertz[core.clock] * periods[core.clock])


def _task_order(core: Any) -> int:
    return int(TaskOrder.INTERLEAVED if core.tasks == "interleaved" else TaskOrder.FIRST_FREE)


def _supply(parts: Any, core: Any) -> tuple[UnitSpec, FifoSpec]:
    """The unit that makes the cores' tasks and the fifo between; an ideal one for tasks assigned beforehand."""
    if core.tasks == "interleaved":
        return UnitSpec(0), FifoSpec(1)
    (unit,) = (part for part in parts.values() if part.kind == "unit" and part.output == core.tasks)
    return UnitSpec(unit.interval_cycles), FifoSpec(parts[core.tasks].entries)


def _dram_name(parts: Any, name: str) -> str:
    """The DRAM at the end of the chain that starts with a cache."""
    while parts[name].kind == "cache":
        name = parts[name].next
    return name


def _caches(parts: Any, core: Any) -> tuple[tuple[CacheSpec, ...], tuple[str, ...], tuple[int, ...]]:
    """Caches, children first, their component names, and the index of the one each core talks to."""
    levels = []
    name = core.memory
    while parts[name].kind == "cache":
        levels.append((name, core.count if parts[name].private else 1))
        name = parts[name].next
    first, caches, names = 0, [], []
    for level, (name, count) in enumerate(levels):
        following = first + count
        for index in range(count):
            shared = level + 1 < len(levels) and levels[level + 1][1] == 1
            parent = following if shared else following + index
            caches.append(_cache(parts[name], parent if level + 1 < len(levels) else DRAM_PARENT))
            names.append(name)
        first = following
    core_cache = tuple(core_index if levels[0][1] > 1 else 0 for core_index in range(core.count))
    return tuple(caches), tuple(names), core_cache


def _cache(part: Any, parent: int) -> CacheSpec:
    return CacheSpec(
        num_sets=part.size // (part.ways * part.line),
        num_ways=part.ways,
        line_bytes=part.line,
        hit_cycles=part.hit_cycles,
        num_mshrs=part.mshrs,
        num_targets=part.targets,
        num_ports=part.ports,
        parent=parent,
    )


def _dram(part: Any, line_bytes: int, period_ticks: int) -> DramSpec:
    fields = _address_fields(part, line_bytes)
    return DramSpec(
        num_channels=part.channels,
        num_banks=part.banks,
        period_ticks=period_ticks,
        burst_beats=part.burst_beats,
        beat_bytes=part.channel_width,
        num_queue_entries=part.queue_entries,
        scheduler=int(Scheduler[part.scheduler.upper()]),
        max_wait_clocks=part.max_wait_clocks,
        channel=fields["channel"],
        bank=fields["bank"],
        row=fields["row"],
        timing=DramTiming(**{name: getattr(part.timing, name) for name in DramTiming._fields}),
    )


def _address_fields(part: Any, line_bytes: int) -> dict[str, AddressField]:
    """Bit fields of `row:bank:line:channel:offset`, read from the left, most significant first."""
    bits = {
        "offset": _log2(line_bytes),
        "channel": _log2(part.channels),
        "line": _log2(part.row_bytes // line_bytes),
        "bank": _log2(part.banks),
        "row": _log2(part.rows),
    }
    fields, shift = {}, 0
    for name in reversed(part.address_map.split(":")):
        fields[name] = AddressField(shift, bits[name])
        shift += bits[name]
    return fields


def _log2(value: int) -> int:
    return value.bit_length() - 1
