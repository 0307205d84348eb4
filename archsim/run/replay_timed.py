"""Replay an address trace on the caches and the DRAM of a machine, with time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import NamedTuple

from archsim.errors import fail
from archsim.machine.build import PhaseMachine
from archsim.machine.counters import Counters
from archsim.machine.entry import asked_by_units, entered_at
from archsim.machine.heard import Heard
from archsim.machine.pipeline import play as pipeline
from archsim.machine.play import play
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.dram.commands import CommandSink
from archsim.model.dram.spec import DramSpec
from archsim.model.unit.spec import UnitSpec
from archsim.run.measure import measured
from archsim.run.metrics import CACHES, DRAM, CacheView, DramView, PhaseView, phase_checks
from archsim.run.pipeline_metrics import pipeline_checks, without_cores
from archsim.run.progress import Progress
from archsim.run.replay import Census, Replay, both_names, replay_of, wanted_of
from archsim.run.replay_statistics import REPLAY, SPEED, TRACE, speed_below_caches
from archsim.run.result import Check
from archsim.trace.access_work import Reopen, clocked_work, dealt_work, requesters_work
from archsim.trace.stream import PipelineWork

Record = Callable[[DramSpec], AbstractContextManager[CommandSink | None]]


def _unrecorded(_: DramSpec) -> AbstractContextManager[None]:
    return nullcontext()


class Play(NamedTuple):
    """How a trace is replayed with time."""

    model: str
    num_outstanding: int  # accesses of a trace with one requester that may be under way
    progress: Progress
    at_cycles: bool = (
        False  # make an access at its cycle, a core cycle, not when the one before has been answered
    )
    flush: bool = False  # write dirty lines back at the end
    record: Record = _unrecorded  # who takes the commands of the DRAM


class Played(NamedTuple):
    """What came out."""

    machine: PhaseMachine
    counters: Counters
    checks: list[Check]


def replay_with_time(name: str, reopen: Reopen, machine: PhaseMachine, cache: int, how: Play) -> Replay:
    """Every requester makes its accesses in order; the replay is over when all that they cause is."""
    census = Census()
    for _ in census.watch(reopen()):
        pass
    played = (_at_cycles if how.at_cycles else _at_answers)(
        reopen, machine, cache, census.last_requester + 1, how
    )
    return _result(name, played, census)


def _at_answers(reopen: Reopen, machine: PhaseMachine, cache: int, num_requesters: int, how: Play) -> Played:
    """A requester is a thread, and makes an access when the one before has been answered."""
    line_bytes = machine.spec.caches[cache].line_bytes
    if num_requesters == 1:
        core = machine.spec.core._replace(
            num_cores=1, num_threads=how.num_outstanding, task_order=int(TaskOrder.FIRST_FREE)
        )
        machine, work = entered_at(machine, cache, core), dealt_work(reopen, line_bytes)
    else:
        machine = _with_requesters(machine, cache, num_requesters)
        num_threads = machine.spec.core.num_cores * machine.spec.core.num_threads
        work = requesters_work(reopen, line_bytes, num_threads)

    def told(done: int, all_: int) -> None:
        how.progress("replaying", done, all_)

    with how.record(machine.spec.dram) as sink:
        counters = play(how.model, machine.spec, work, told, Heard(sink), flush=how.flush)
    return Played(machine, counters, phase_checks("replay", machine, counters))


def _with_requesters(machine: PhaseMachine, cache: int, num_requesters: int) -> PhaseMachine:
    """The machine with a thread for each requester: those of its cores, or, further down, a core for each."""
    core = machine.spec.core
    if cache != machine.spec.core_cache[0]:
        return entered_at(
            machine, cache, CoreSpec(num_requesters, 1, core.period_ticks, TaskOrder.INTERLEAVED)
        )
    _check_threads(core, num_requesters)
    spec = machine.spec._replace(
        core=core._replace(task_order=int(TaskOrder.INTERLEAVED)), source=UnitSpec(0)
    )
    return machine._replace(spec=spec)


def _check_threads(core: CoreSpec, num_requesters: int) -> None:
    """ArchsimError unless there is a thread for each requester."""
    if num_requesters > core.num_cores * core.num_threads:
        threads = f"{core.num_cores} x {core.num_threads} threads"
        raise fail(f"the trace has requesters up to {num_requesters - 1}; the cores have {threads}")


def _at_cycles(reopen: Reopen, machine: PhaseMachine, cache: int, num_requesters: int, how: Play) -> Played:
    """A requester is a pair of units, and makes an access at its cycle."""
    core = machine.spec.core
    caches = [0] * num_requesters
    if num_requesters == 1 or cache != machine.spec.core_cache[0]:
        machine = entered_at(machine, cache, core._replace(num_cores=1, num_threads=1))
    else:
        _check_threads(core, num_requesters)
        caches = [machine.spec.core_cache[number // core.num_threads] for number in range(num_requesters)]
    asked = asked_by_units(machine, caches)
    work = clocked_work(reopen, asked.spec.units[0].line_bytes, num_requesters)
    with how.record(machine.spec.dram) as sink:
        counters = pipeline.play(
            how.model, asked, PipelineWork(asked.units, work), heard=Heard(sink), flush=how.flush
        )
    return Played(without_cores(asked), counters.memory, pipeline_checks("replay", asked, counters))


def _result(name: str, played: Played, census: Census) -> Replay:
    machine, counters, checks = played
    view = PhaseView(machine, counters)
    distinct = list(dict.fromkeys(machine.cache_names))
    names = both_names(distinct)
    statistics = measured("trace", TRACE, census.kinds) + measured("replay", REPLAY, (view, census.kinds))
    for level, number in names:
        members = [k for k, other in enumerate(machine.cache_names) if other == distinct[number]]
        statistics += measured(level, CACHES, CacheView(view, members))
    statistics += measured("dram", DRAM, DramView(view)) + measured(
        "dram", SPEED, speed_below_caches(DramView(view))
    )
    dram = ["requests", "row_hits", "row_misses", "row_conflicts", "gigabytes_per_second", "peak_percent"]
    wanted = ["replay.cycles", *wanted_of(distinct, dram)]
    return replay_of(name, statistics, checks, wanted)
