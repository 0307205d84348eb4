"""The requests of a run at one level of its machine, as an address trace."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from archsim.config import RunConfig
from archsim.errors import did_you_mean, fail
from archsim.machine.build import PhaseMachine
from archsim.machine.heard import NOTHING, Heard
from archsim.machine.pipeline.build import PipelineMachine
from archsim.machine.watch import Watch
from archsim.run.kinds import kind_of
from archsim.run.progress import Progress
from archsim.run.replay import level_named
from archsim.run.result import Result

Take = Callable[[np.ndarray], None]  # takes ACCESS records, whose cycles never fall
_DRAM = "dram"


def export(config: RunConfig, level: str, phase: str | None, take: Take, progress: Progress) -> Result:
    """Simulate the run and hand the requests that reach a level to `take`; of one phase only, if one is named.

    Phases follow each other: the cycles of each begin behind those of the one before. A level is a cache's name,
    l1, l2, ... as the cores of the phase see it, or dram.
    """
    end, phases = [0], dict[str, None]()  # of what was taken, and the names that were heard

    def listen(name: str, machine: PhaseMachine | PipelineMachine) -> Heard:
        phases[name] = None
        if phase not in (None, name):
            return NOTHING
        begin = end[0]

        def tell(accesses: np.ndarray) -> None:
            accesses["cycle"] += begin
            end[0] = int(accesses["cycle"][-1])
            take(accesses)

        return Heard(watch=Watch(_places(machine, level), tell))

    result = kind_of(config).simulate(config, progress, listen=listen)
    check_phase(phase, phases)
    return result


def check_phase(phase: str | None, phases: dict[str, None]) -> None:
    """ArchsimError for a phase that a run does not have."""
    if phase is not None and phase not in phases:
        hint = did_you_mean(phase, phases) or f"there are: {', '.join(phases)}"
        raise fail(f"no phase is named '{phase}'", hint=hint)


def _places(machine: PhaseMachine | PipelineMachine, level: str) -> tuple[int, ...]:
    """The caches of the level, or the DRAM. ArchsimError if there is no such level."""
    if level.lower() == _DRAM:
        return (len(machine.spec.caches),)
    if isinstance(machine, PipelineMachine):
        if level not in machine.caches:
            hint = did_you_mean(level, machine.caches) or f"there are: {', '.join((*machine.caches, _DRAM))}"
            raise fail(f"the pipeline has no cache '{level}'", hint=hint)
        return (machine.caches.index(level),)
    names = machine.cache_names
    first = level_named(machine, level if level in names else level.lower())
    return tuple(place for place, name in enumerate(names) if name == names[first])
