"""From a machine's description to the numbers that a phase is played on."""

from __future__ import annotations

from typing import NamedTuple

from archsim.config.components import (
    INTERLEAVED,
    CacheConfig,
    CoreConfig,
    DramConfig,
    FifoConfig,
    LocksConfig,
)
from archsim.config.machine import MachineConfig, path_down
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
    cache_names: tuple[str, ...]  # [num_caches] component of each cache; private ones repeat their name
    tick_hertz: int
    dram_bytes: int  # capacity


def phase_machine(machine: MachineConfig, role: str) -> PhaseMachine:
    """The components reachable from the cores that play `role`; the machine has been checked."""
    return group_machine(machine, getattr(machine.roles, role))


def group_machine(machine: MachineConfig, group: str) -> PhaseMachine:
    """The components reachable from a group of cores."""
    core = machine.all_of(CoreConfig)[group]
    periods = clock_periods(machine.clocks)
    levels = path_down(machine, core.memory)
    dram = machine.all_of(DramConfig)[machine.all_of(CacheConfig)[levels[-1]].next]
    caches, names = _caches([machine.all_of(CacheConfig)[name] for name in levels], levels, core.count)
    source, fifo = _supply(machine, core)
    order = TaskOrder.INTERLEAVED if core.tasks == INTERLEAVED else TaskOrder.FIRST_FREE
    private = names.count(levels[0]) > 1
    spec = MachineSpec(
        CoreSpec(core.count, core.threads, periods[core.clock], int(order)),
        tuple(index if private else 0 for index in range(core.count)),
        LocksSpec(machine.all_of(LocksConfig)[core.locks].count if core.locks else 0),
        source,
        fifo,
        caches,
        _dram(dram, caches[-1].line_bytes, periods[dram.clock]),
    )
    capacity = dram.channels * dram.banks * dram.rows * dram.row_bytes
    return PhaseMachine(spec, names, machine.clocks[core.clock] * periods[core.clock], capacity)


def _supply(machine: MachineConfig, core: CoreConfig) -> tuple[UnitSpec, FifoSpec]:
    """The unit that makes the cores' tasks and the fifo between; an ideal one for tasks assigned beforehand."""
    unit = machine.feeder(core.tasks)
    if unit is None:
        return UnitSpec(0), FifoSpec(1)
    return UnitSpec(unit.interval_cycles), FifoSpec(machine.all_of(FifoConfig)[core.tasks].entries)


def _caches(
    levels: list[CacheConfig], level_names: list[str], num_cores: int
) -> tuple[tuple[CacheSpec, ...], tuple[str, ...]]:
    """Caches from the cores down, and their component names; a private level has one cache for each core."""
    counts = [num_cores if level.private else 1 for level in levels]
    caches: list[CacheSpec] = []
    names: list[str] = []
    for k, level in enumerate(levels):
        below = len(caches) + counts[k]  # index of the next level's first cache
        for index in range(counts[k]):
            if k + 1 == len(levels):
                parent = DRAM_PARENT
            else:
                parent = below + (index if counts[k + 1] > 1 else 0)
            caches.append(_cache(level, parent))
            names.append(level_names[k])
    return tuple(caches), tuple(names)


def _cache(config: CacheConfig, parent: int) -> CacheSpec:
    return CacheSpec(
        num_sets=config.num_sets,
        num_ways=config.ways,
        line_bytes=config.line,
        hit_cycles=config.hit_cycles,
        num_mshrs=config.mshrs,
        num_targets=config.targets,
        num_ports=config.ports,
        parent=parent,
    )


def _dram(config: DramConfig, line_bytes: int, period_ticks: int) -> DramSpec:
    fields = {name: AddressField(*place) for name, place in config.address_fields(line_bytes).items()}
    return DramSpec(
        num_channels=config.channels,
        num_banks=config.banks,
        period_ticks=period_ticks,
        burst_beats=config.burst_beats,
        beat_bytes=config.channel_width,
        num_queue_entries=config.queue_entries,
        scheduler=int(Scheduler[config.scheduler.upper()]),
        max_wait_clocks=config.max_wait_clocks,
        channel=fields["channel"],
        bank=fields["bank"],
        row=fields["row"],
        timing=DramTiming(**{name: getattr(config.timing, name) for name in DramTiming._fields}),
    )
