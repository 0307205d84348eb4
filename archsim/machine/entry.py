"""The part of a machine below one of its caches, asked by whoever replays a trace."""

from __future__ import annotations

from archsim.machine.build import PhaseMachine
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.core.spec import CoreSpec
from archsim.model.fifo.spec import FifoSpec
from archsim.model.unit.spec import UnitSpec


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
