"""Play a pipeline's work, by either model."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from archsim.errors import did_you_mean, fail
from archsim.machine.heard import NOTHING, Heard
from archsim.machine.pipeline.build import PipelineMachine
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.pipeline.series import pipeline_sample
from archsim.machine.play import MODELS, asked_of
from archsim.trace.stream import PipelineWork


def play(
    model: str,
    machine: PipelineMachine,
    work: PipelineWork,
    progress: Callable[[int], None] | None = None,
    heard: Heard = NOTHING,
    flush: bool = False,
) -> PipelineCounters:
    """Counters of the work on the machine; `progress` is called with the tasks ended now and then.

    With `flush` dirty lines are written back at the end.
    ArchsimError if the work is for other units than the machine has. Loads only the model asked for: each brings a
    heavy library.
    """
    if model not in MODELS:
        raise ValueError(f"no model named {model!r}")
    _check_units(machine, work)
    module = import_module(f"archsim.machine.pipeline.{model}")
    counters: PipelineCounters = module.simulate(
        machine.spec, work, progress, **asked_of(model, heard), flush=flush
    )
    if heard.sampling is not None:
        heard.sampling.take(pipeline_sample(counters.memory.drained_cycles + 1, counters))
    return counters


def _check_units(machine: PipelineMachine, work: PipelineWork) -> None:
    """ArchsimError unless the work's units are the machine's, in its order."""
    for name in work.units:
        if name not in machine.units:
            hint = did_you_mean(name, machine.units) or f"there are: {', '.join(machine.units)}"
            raise fail(f"the machine has no unit '{name}', for which there is work", hint=hint)
    if work.units != machine.units:
        raise fail(f"the work is for the units {', '.join(work.units)}; there are {', '.join(machine.units)}")
