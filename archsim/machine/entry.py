"""The part of a machine below one of its caches, asked by whoever replays a trace."""

from __future__ import annotations

from archsim.machine.build import PhaseMachine
from archsim.machine.pipeline.build import PipelineMachine
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.core.spec import CoreSpec
from archsim.model.fifo.spec import FifoSpec
from archsim.model.unit.spec import StageSpec, UnitSpec


def path_from(machine: PhaseMachine, cache: int) -> list[int]:
    """The caches from one down to the last before the DRAM."""
    path = [cache]
    while (parent := machine.spec.caches[path[-1]].parent) != DRAM_PARENT:
        path.append(parent)
    return path


def entered_at(machine: PhaseMachine, cache: int, core: CoreSpec) -> PhaseMachine:
    """The caches from one down, and the DRAM, with all of `core`'s cores on the first."""
    path = path_from(machine, cache)
    parents = [*range(1, len(path)), DRAM_PARENT]
    caches = [machine.spec.caches[k]._replace(parent=parent) for k, parent in zip(path, parents, strict=True)]
    spec = machine.spec._replace(
        core=core,
        core_cache=(0,) * core.num_cores,
        source=UnitSpec(0),
        fifo=FifoSpec(1),
        caches=tuple(caches),
    )
    return machine._replace(spec=spec, cache_names=tuple(machine.cache_names[k] for k in path))


MOST_UNDER_WAY = (
    1024  # accesses of a requester that keeps to its cycles; a later one waits, and so do all behind it
)


def asked_by_units(machine: PhaseMachine, caches: list[int]) -> PipelineMachine:
    """The machine's caches and DRAM with two units before each of `caches`, one that reads and one that writes."""
    spec = machine.spec
    units = [
        StageSpec(
            interval_cycles=0,
            latency_cycles=1,
            lanes=1,
            inputs=(),
            outputs=(),
            pools=(),
            memory=cache,
            line_bytes=spec.caches[cache].line_bytes,
            outstanding=MOST_UNDER_WAY,
            in_flight=MOST_UNDER_WAY,
        )
        for cache in caches
        for _ in ("reads", "writes")
    ]
    names = tuple(f"requester {k} {what}" for k in range(len(caches)) for what in ("reads", "writes"))
    pipeline = PipelineSpec(spec.core.period_ticks, tuple(units), (), (), (), spec.caches, spec.dram)
    return PipelineMachine(
        pipeline, names, (), (), machine.cache_names, machine.tick_hertz, machine.dram_bytes
    )
