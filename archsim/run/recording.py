"""Runs of which one phase is recorded: the commands of its DRAM, or what happens in some of its cycles."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from typing import Any, NamedTuple, TypeVar

from archsim.config import RunConfig
from archsim.config.run import StatisticsConfig
from archsim.errors import did_you_mean, fail
from archsim.machine.build import PhaseMachine
from archsim.machine.heard import NOTHING, Heard
from archsim.machine.pipeline.build import PipelineMachine
from archsim.machine.pipeline.timeline import PipelineRecorder, TaskRecorder
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


AnyMachine = PhaseMachine | PipelineMachine
AnyRecorder = TypeVar("AnyRecorder", bound=Recorder | PipelineRecorder)


class Recorded(NamedTuple):
    """Some cycles of a phase, and the machine that played it."""

    phase: str
    machine: AnyMachine
    timeline: Timeline
    window: Window  # what was recorded


def record_cycles(config: RunConfig, window: Window, phase: str | None = None) -> list[Recorded]:
    """What happens in these cycles of the phase, or of every phase, of its first playing.

    Plays the run once more, on the reference model, each phase up to the window's end.
    """

    def recorder(name: str, machine: AnyMachine) -> Recorder | PipelineRecorder:
        if isinstance(machine, PipelineMachine):
            return PipelineRecorder(machine.spec, window)
        return Recorder(machine.spec, window)

    found: list[tuple[str, AnyMachine, Recorder | PipelineRecorder]] = _record(config, phase, recorder)
    return [Recorded(name, machine, each.timeline(), window) for name, machine, each in found]


def record_tasks(
    config: RunConfig, tasks: Window, unit: str | None = None, phase: str | None = None
) -> list[Recorded]:
    """What happens while a unit, or every unit, does these of its tasks, in the phase or in all that pipelines play.

    Plays the run once more, on the reference model, each phase until the tasks are done.
    """

    def recorder(name: str, machine: AnyMachine) -> TaskRecorder | None:
        if not isinstance(machine, PipelineMachine):
            if name == phase:
                raise fail(f"the phase '{name}' is played on cores", hint="name cycles of it (--cycles)")
            return None
        return TaskRecorder(machine.spec, tasks, _numbers(machine, unit))

    found = _record(config, phase, recorder)
    recorded = [
        Recorded(name, machine, each.timeline(), window)
        for name, machine, each in found
        if (window := each.window()) is not None
    ]
    if not recorded:
        most = max(max(each.numbers[number, 0] for number in each.units) for _, _, each in found)
        whose = f"the unit '{unit}'" if unit is not None else "every unit"
        raise fail(f"{whose} has {most} tasks at most, none of them from {tasks.first} on")
    return recorded


def _numbers(machine: PipelineMachine, unit: str | None) -> list[int]:
    """The unit, or all of them. ArchsimError if there is no such unit."""
    if unit is None:
        return list(range(len(machine.units)))
    if unit not in machine.units:
        hint = did_you_mean(unit, machine.units) or f"there are: {', '.join(machine.units)}"
        raise fail(f"the pipeline has no unit '{unit}'", hint=hint)
    return [machine.units.index(unit)]


def _record(
    config: RunConfig, phase: str | None, recorder: Callable[[str, AnyMachine], AnyRecorder | None]
) -> list[tuple[str, AnyMachine, AnyRecorder]]:
    """Play the run on the reference model, with a recorder for each phase that has one, in its first playing."""
    recorders: dict[str, tuple[AnyMachine, AnyRecorder]] = {}
    phases = dict[str, None]()

    def listen(name: str, machine: AnyMachine) -> Heard:
        is_first, phases[name] = name not in phases, None
        own = recorder(name, machine) if is_first and phase in (None, name) else None
        if own is None:
            return Heard(observe=_pass_over)
        recorders[name] = machine, own
        return Heard(observe=own.attach)

    plain = config.model_copy(update={"model": "reference", "statistics": StatisticsConfig()})
    kind_of(plain).simulate(plain, silent, listen=listen)
    check_phase(phase, phases)
    return [(name, machine, own) for name, (machine, own) in recorders.items()]


def _pass_over(machine: Any) -> None:
    """End a phase before anything happens in it."""
    stop_at(machine.env, 0)
