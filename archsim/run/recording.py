"""Runs of which one phase is recorded: the commands of its DRAM, or what happens in some of its cycles."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from typing import Any, NamedTuple

from archsim.config import RunConfig
from archsim.config.run import StatisticsConfig
from archsim.errors import fail
from archsim.machine.build import PhaseMachine
from archsim.machine.heard import NOTHING, Heard
from archsim.machine.pipeline.build import PipelineMachine
from archsim.machine.pipeline.timeline import PipelineRecorder
from archsim.machine.timeline import Recorder, Timeline, Window
from archsim.model.dram.commands import CommandSink
from archsim.model.dram.spec import DramSpec, Scheduler
from archsim.model.reference import stop_at
from archsim.run.export import check_phase
from archsim.run.kinds import kind_of
from archsim.run.progress import Progress, silent
from archsim.run.result import Result

Record = Callable[[DramSpec], AbstractContextManager[CommandSink]]


def record_commands(config: RunConfig, phase: str | None, record: Record, progress: Progress) -> Result:
    """Simulate the run; the DRAM's commands in the phase, or the first one, go where `record` says.

    Of a phase that is played several times, for several light views say, the first playing is recorded.
    """
    phases = dict[str, None]()
    with ExitStack() as stack:

        def listen(name: str, machine: PhaseMachine | PipelineMachine) -> Heard:
            wanted = name not in phases and name == (phase or next(iter(phases), name))
            phases[name] = None
            if not wanted:
                return NOTHING
            if machine.spec.dram.scheduler == Scheduler.IDEAL:
                raise fail("an ideal DRAM has no commands")
            return Heard(sink=stack.enter_context(record(machine.spec.dram)))

        result: Result = kind_of(config).simulate(config, progress, listen=listen)
    check_phase(phase, phases)
    return result


class Recorded(NamedTuple):
    """Some cycles of a phase, and the machine that played it."""

    phase: str
    machine: PhaseMachine | PipelineMachine
    timeline: Timeline


def record_cycles(config: RunConfig, window: Window, phase: str | None = None) -> list[Recorded]:
    """What happens in these cycles of the phase, or of every phase, of its first playing.

    Plays the run once more, on the reference model, each phase up to the window's end.
    """
    recorders: dict[str, tuple[PhaseMachine | PipelineMachine, Recorder | PipelineRecorder]] = {}
    phases = dict[str, None]()

    def listen(name: str, machine: PhaseMachine | PipelineMachine) -> Heard:
        is_first, phases[name] = name not in phases, None
        if not is_first or phase not in (None, name):
            return Heard(observe=_pass_over)
        if isinstance(machine, PipelineMachine):
            recorders[name] = machine, PipelineRecorder(machine.spec, window)
        else:
            recorders[name] = machine, Recorder(machine.spec, window)
        return Heard(observe=recorders[name][1].attach)

    plain = config.model_copy(update={"model": "reference", "statistics": StatisticsConfig()})
    kind_of(plain).simulate(plain, silent, listen=listen)
    check_phase(phase, phases)
    return [Recorded(name, machine, recorder.timeline()) for name, (machine, recorder) in recorders.items()]


def _pass_over(machine: Any) -> None:
    """End a phase before anything happens in it."""
    stop_at(machine.env, 0)
