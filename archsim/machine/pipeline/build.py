"""From a machine's description to the numbers that a pipeline is played on."""

from __future__ import annotations

from typing import NamedTuple

from archsim.config.components import FifoConfig
from archsim.config.machine import MachineConfig
from archsim.config.stages import DelayStreamConfig, PoolConfig, StageConfig
from archsim.config.tiles import EvaluatorConfig
from archsim.errors import fail
from archsim.lograster.evaluators import EvaluatorCost, evaluator_cost, evaluator_spec
from archsim.lograster.grid import BITS, TILE
from archsim.machine.build import cache_spec, dram_component, dram_spec
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.delay_stream.spec import DelayStreamSpec, Overflow
from archsim.model.fifo.spec import FifoSpec
from archsim.model.pool.spec import PoolSpec
from archsim.model.unit.spec import NO_MEMORY, StageSpec
from archsim.units import clock_periods

ANY_LINE_BYTES = 64  # where nobody asks the DRAM


class PipelineMachine(NamedTuple):
    """A pipeline and the names of its components, in the order of their numbers."""

    spec: PipelineSpec
    units: tuple[str, ...]
    channels: tuple[str, ...]  # fifos, then delay streams
    pools: tuple[str, ...]
    caches: tuple[str, ...]
    tick_hertz: int
    dram_bytes: int  # capacity


def pipeline_machine(machine: MachineConfig) -> PipelineMachine:
    """The pipeline that the units of a machine are; the machine has been checked. ArchsimError if it has none."""
    stages = machine.all_of(StageConfig)
    if not stages:
        raise fail(f"machine '{machine.name}' has no units with inputs and outputs: it is no pipeline")

    clock = next(iter(stages.values())).clock
    period_ticks = clock_periods(machine.clocks)[clock]
    streams = machine.all_of(DelayStreamConfig)
    between = {*(n for s in stages.values() for n in s.outputs)}
    fifos = {name: fifo for name, fifo in machine.all_of(FifoConfig).items() if name in between}
    channels, pools = (*fifos, *streams), tuple(machine.all_of(PoolConfig))
    caches = _caches(machine, stages)
    dram = dram_component(machine, _dram_name(machine))
    spec = PipelineSpec(
        period_ticks=period_ticks,
        units=tuple(_stage(machine, stage, channels, pools, caches) for stage in stages.values()),
        fifos=tuple(FifoSpec(fifo.entries) for fifo in fifos.values()),
        delay_streams=tuple(_delay_stream(stream) for stream in streams.values()),
        pools=tuple(PoolSpec(pool.count) for pool in machine.all_of(PoolConfig).values()),
        caches=tuple(
            cache_spec(machine.caches[name], _number(machine.caches[name].next, caches)) for name in caches
        ),
        dram=dram_spec(
            dram, _longest_line(machine, stages, caches), clock_periods(machine.clocks)[dram.clock]
        ),
    )
    hertz = machine.clocks[clock] * period_ticks
    return PipelineMachine(spec, tuple(stages), channels, pools, caches, hertz, dram.capacity_bytes)


def _dram_name(machine: MachineConfig) -> str:
    return next(name for name, each in machine.components.items() if each.kind in ("dram", "ideal_dram"))


def _caches(machine: MachineConfig, stages: dict[str, StageConfig]) -> tuple[str, ...]:
    """Names of the caches below the units, children before their parents."""
    paths = [machine.caches_below(stage.memory or "") for stage in stages.values()]
    heights = {name: len(path) - level for path in paths for level, name in enumerate(path)}
    return tuple(sorted(heights, key=lambda name: -heights[name]))


def _number(name: str, caches: tuple[str, ...]) -> int:
    """The number of a cache, DRAM_PARENT for the DRAM."""
    return caches.index(name) if name in caches else DRAM_PARENT


def _longest_line(machine: MachineConfig, stages: dict[str, StageConfig], caches: tuple[str, ...]) -> int:
    """The longest request to the DRAM: so many bytes lie in one channel."""
    lines = [stage.line for stage in stages.values() if stage.line is not None]
    lines += [stream.line for stream in machine.all_of(DelayStreamConfig).values()]
    lines += [machine.caches[name].line for name in caches]
    return max(lines, default=ANY_LINE_BYTES)


def _stage(
    machine: MachineConfig,
    stage: StageConfig,
    channels: tuple[str, ...],
    pools: tuple[str, ...],
    caches: tuple[str, ...],
) -> StageSpec:
    memory, line_bytes = NO_MEMORY, stage.line or 1
    if stage.memory is not None:
        memory = _number(stage.memory, caches)
    if memory >= 0:
        line_bytes = machine.caches[caches[memory]].line
    evaluators = _evaluators(machine, stage)
    return StageSpec(
        interval_cycles=max([stage.interval_cycles, *(each.interval_cycles for each in evaluators)]),
        latency_cycles=max([stage.latency_cycles, *(each.latency_cycles for each in evaluators)]),
        lanes=stage.lanes,
        inputs=tuple(channels.index(name) for name in stage.inputs),
        outputs=tuple(channels.index(name) for name in stage.outputs),
        pools=tuple(pools.index(name) for name in stage.pools),
        memory=memory,
        line_bytes=line_bytes,
        outstanding=stage.outstanding,
        in_flight=stage.in_flight,
    )


def _evaluators(machine: MachineConfig, stage: StageConfig) -> list[EvaluatorCost]:
    """What the unit's evaluators take; their time does not depend on the number of rows."""
    evaluators = [machine.find(name, EvaluatorConfig) for name in stage.parts]
    return [evaluator_cost(evaluator_spec(each), TILE, BITS) for each in evaluators if each is not None]


def _delay_stream(config: DelayStreamConfig) -> DelayStreamSpec:
    return DelayStreamSpec(
        ring_bytes=config.size,
        base=config.address,
        line_bytes=config.line,
        outstanding=config.outstanding,
        prefetch_bytes=config.prefetch,
        overflow=int(Overflow[config.overflow.upper()]),
    )
