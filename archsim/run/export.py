"""The requests of a run at one level of its machine, as an address trace."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from archsim.config import RunConfig
from archsim.errors import did_you_mean, fail
from archsim.machine.build import PhaseMachine
from archsim.machine.watch import Watch
from archsim.run.izb import simulate_izb
from archsim.run.izb_statistics import BUILD, CLEAR, RASTER
from archsim.run.progress import Progress
from archsim.run.replay import level_named
from archsim.run.result import Result

Take = Callable[[np.ndarray], None]  # takes ACCESS records, whose cycles never fall
PHASES = (CLEAR, BUILD, RASTER)
_DRAM = "dram"


def export(config: RunConfig, level: str, phase: str | None, take: Take, progress: Progress) -> Result:
    """Simulate the run and hand the requests that reach a level to `take`; of one phase only, if one is named.

    Phases follow each other: the cycles of each begin behind those of the one before. A level is a cache's name,
    l1, l2, ... as the cores of the phase see it, or dram.
    """
    if not config.workload.kind.startswith("izb"):
        raise fail(
            f"a workload of kind '{config.workload.kind}' has no cores whose requests could be exported"
        )
    if phase is not None and phase not in PHASES:
        raise fail(
            f"no phase is named '{phase}'",
            hint=did_you_mean(phase, PHASES) or f"there are: {', '.join(PHASES)}",
        )

    end = [0]  # of what was taken

    def watch(name: str, machine: PhaseMachine) -> Watch | None:
        if phase not in (None, name):
            return None
        begin = end[0]

        def tell(accesses: np.ndarray) -> None:
            accesses["cycle"] += begin
            end[0] = int(accesses["cycle"][-1])
            take(accesses)

        return Watch(_places(machine, level), tell)

    return simulate_izb(config, progress, watch)


def _places(machine: PhaseMachine, level: str) -> tuple[int, ...]:
    """The caches of the level, or the DRAM. ArchsimError if there is no such level."""
    if level.lower() == _DRAM:
        return (len(machine.spec.caches),)
    first = level_named(machine, level if level in machine.cache_names else level.lower())
    names = machine.cache_names
    return tuple(place for place, name in enumerate(names) if name == names[first])
