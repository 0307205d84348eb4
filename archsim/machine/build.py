"""From a machine's description to the numbers that a phase is played on."""

from __future__ import annotations

from typing import NamedTuple

from archsim.config.components import (
    INTERLEAVED,
    CacheConfig,
    ClearBitsConfig,
    CoreConfig,
    DramConfig,
    FifoConfig,
    IdealDramConfig,
    LocksConfig,
)
from archsim.config.dram import TimingConfig
from archsim.config.machine import MachineConfig
from archsim.machine.spec import MachineSpec
from archsim.model.cache.spec import (
    DRAM_PARENT,
    NO_CLEAR_BITS,
    Arbiter,
    CacheSpec,
    ClearSpec,
    Replacement,
    VictimOrder,
    WritePolicy,
)
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.dram.spec import AddressField, DramSpec, DramTiming, PagePolicy, Scheduler
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks.spec import LocksSpec
from archsim.model.unit.spec import UnitSpec
from archsim.units import clock_periods

_SEED_STEP = 0x9E3779B1  # between the caches of a machine, so that no two draw alike


class PhaseMachine(NamedTuple):
    """The part of a machine that plays one phase."""

    spec: MachineSpec
    cache_names: tuple[str, ...]  # [num_caches] component of each cache; private ones repeat their name
    tick_hertz: int
    dram_bytes: int  # capacity
    fifo: str | None = None  # component that tasks wait in for their thread, if any


def phase_machine(machine: MachineConfig, role: str, seed: int = 0) -> PhaseMachine:
    """The components reachable from the cores that play `role`; the machine has been checked.

    `seed` is that of what is drawn at random: the victims of caches with random replacement.
    """
    return group_machine(machine, getattr(machine.roles, role), seed)


def group_machine(machine: MachineConfig, group: str, seed: int = 0) -> PhaseMachine:
    """The components reachable from a group of cores."""
    core = machine.all_of(CoreConfig)[group]
    periods = clock_periods(machine.clocks)
    levels = machine.caches_below(core.memory)
    dram = dram_component(machine, machine.all_of(CacheConfig)[levels[-1]].next)
    caches, names = _caches([machine.all_of(CacheConfig)[name] for name in levels], levels, core.count)
    caches = tuple(cache._replace(seed=seed + index * _SEED_STEP) for index, cache in enumerate(caches))
    source, fifo = _supply(machine, core)
    order = TaskOrder.INTERLEAVED if core.tasks == INTERLEAVED else TaskOrder.FIRST_FREE
    private = names.count(levels[0]) > 1
    spec = MachineSpec(
        CoreSpec(core.count, core.threads, periods[core.clock], int(order)),
        tuple(index if private else 0 for index in range(core.count)),
        _locks(machine, core),
        source,
        fifo,
        caches,
        dram_spec(dram, caches[-1].line_bytes, periods[dram.clock]),
    )
    hertz = machine.clocks[core.clock] * periods[core.clock]
    waits_in = core.tasks if source.interval_cycles > 0 else None
    return PhaseMachine(spec, names, hertz, dram.capacity_bytes, waits_in)


def _locks(machine: MachineConfig, core: CoreConfig) -> LocksSpec:
    if core.locks is None:
        return LocksSpec(0)
    locks = machine.all_of(LocksConfig)[core.locks]
    return LocksSpec(locks.count, locks.ideal)


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
            caches.append(cache_spec(level, parent))
            names.append(level_names[k])
    return tuple(caches), tuple(names)


def cache_spec(config: CacheConfig, parent: int) -> CacheSpec:
    """The cache over cache number `parent`."""
    return CacheSpec(
        num_sets=config.num_sets,
        num_ways=config.ways,
        line_bytes=config.line,
        hit_cycles=config.hit_cycles,
        num_mshrs=config.mshrs,
        num_targets=config.targets,
        num_ports=config.ports,
        parent=parent,
        num_sectors=config.num_sectors,
        replacement=int(Replacement[config.replacement.upper()]),
        write_policy=int(WritePolicy[config.write_policy.upper()]),
        allocates_writes=int(config.write_allocate),
        victim_order=int(VictimOrder[config.victim_order.upper()]),
        num_write_entries=config.write_queue,
        arbiter=int(Arbiter[config.arbiter.upper()]),
        clear=_clear_bits(config.clear_bits),
    )


def _clear_bits(config: ClearBitsConfig | None) -> ClearSpec:
    if config is None:
        return NO_CLEAR_BITS
    num_blocks = config.size // config.block
    return ClearSpec(config.block, config.start, num_blocks, int(config.at_start == "clear"))


def dram_component(machine: MachineConfig, name: str) -> DramConfig | IdealDramConfig:
    """The DRAM of that name; the machine has been checked."""
    ideal = machine.all_of(IdealDramConfig)
    return ideal[name] if name in ideal else machine.all_of(DramConfig)[name]


def dram_spec(config: DramConfig | IdealDramConfig, line_bytes: int, period_ticks: int) -> DramSpec:
    """The DRAM for requests of `line_bytes`."""
    if isinstance(config, IdealDramConfig):
        return _ideal_dram(config, line_bytes, period_ticks)
    fields = {"group": AddressField(0, 0)}
    fields |= {name: AddressField(*place) for name, place in config.address_fields(line_bytes).items()}
    writes = config.write_queue
    return DramSpec(
        num_channels=config.channels,
        num_banks=config.banks,
        num_groups=config.bank_groups,
        period_ticks=period_ticks,
        burst_beats=config.burst_beats,
        clock_beats=config.data_rate,
        beat_bytes=config.channel_width,
        num_queue_entries=config.queue_entries,
        num_write_entries=writes.entries if writes else 0,
        write_high=writes.high if writes else 0,
        write_low=writes.low if writes else 0,
        scheduler=int(Scheduler[config.scheduler.upper()]),
        max_wait_clocks=config.max_wait_clocks,
        page_policy=int(PagePolicy[config.page_policy.upper()]),
        page_timeout_clocks=config.page_timeout_clocks or 0,
        channel=fields["channel"],
        group=fields["group"],
        bank=fields["bank"],
        row=fields["row"],
        line=fields["line"],
        bank_hash=fields["group"].bits + fields["bank"].bits if config.bank_hash == "xor" else 0,
        timing=_timing(config.timing),
    )


def _timing(config: TimingConfig) -> DramTiming:
    """The constraints; those within a bank group are the channel's where there are no groups."""
    given = {name: getattr(config, name) for name in DramTiming._fields}
    within = {f"{name}_l": given[f"{name}_l"] or given[name] for name in ("n_rrd", "n_ccd", "n_wtr")}
    return DramTiming(**{**given, **within, "n_faw": given["n_faw"] or 0})


def _ideal_dram(config: IdealDramConfig, line_bytes: int, period_ticks: int) -> DramSpec:
    """One channel that takes a line as one burst, with all times but the latency zero."""
    nowhere = AddressField(0, 0)
    timing = DramTiming(**{**dict.fromkeys(DramTiming._fields, 0), "n_cl": config.latency_clocks})
    return DramSpec(
        num_channels=1,
        num_banks=1,
        num_groups=1,
        period_ticks=period_ticks,
        burst_beats=1,
        clock_beats=1,
        beat_bytes=line_bytes,
        num_queue_entries=1,
        num_write_entries=0,
        write_high=0,
        write_low=0,
        scheduler=int(Scheduler.IDEAL),
        max_wait_clocks=0,
        page_policy=int(PagePolicy.OPEN),
        page_timeout_clocks=0,
        channel=nowhere,
        group=nowhere,
        bank=nowhere,
        row=nowhere,
        line=nowhere,
        bank_hash=0,
        timing=timing,
    )
