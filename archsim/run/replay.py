"""Replay an address trace on the memory side of a machine: without time, or with it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from archsim.errors import did_you_mean, fail
from archsim.machine.build import PhaseMachine
from archsim.machine.counters import Counters
from archsim.machine.entry import entered_at, path_from
from archsim.machine.play import play
from archsim.model.cache.functional import copy_back, counts_of, new_chain
from archsim.model.cache.functional import replay as replay_chain
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.unit.spec import UnitSpec
from archsim.run.measure import measured
from archsim.run.metrics import CACHES, DRAM, CacheView, DramView, PhaseView, phase_checks
from archsim.run.progress import Progress
from archsim.run.replay_statistics import LEVEL, MEMORY, REPLAY, SPEED, TRACE, speed_below_caches
from archsim.run.result import Check, Statistic
from archsim.trace.access_work import Reopen, dealt_work, requesters_work
from archsim.trace.accesses import Kind


class Bucket(NamedTuple):
    """Reads that took from `least` to `most` clocks."""

    least: int
    most: int
    reads: int


class Replay(NamedTuple):
    """A replayed trace."""

    name: str
    summary: dict[str, Any]  # plain JSON values: the few numbers a person asks for first
    statistics: list[Statistic]
    checks: list[Check]
    latency: list[Bucket]  # how long reads took, if that was counted

    @property
    def ok(self) -> bool:
        return all(check.ok for check in self.checks)

    def tree(self) -> dict[str, Any]:
        """All of it as plain values with names."""
        return {
            "name": self.name,
            "summary": self.summary,
            "statistics": [statistic._asdict() for statistic in self.statistics],
            "checks": [check._asdict() for check in self.checks],
            "latency": [bucket._asdict() for bucket in self.latency],
        }


class Census:
    """Counts what passes."""

    def __init__(self) -> None:
        self.kinds = np.zeros(len(Kind), np.int64)
        self.last_requester = 0

    def watch(self, chunks: Iterator[np.ndarray]) -> Iterator[np.ndarray]:
        for chunk in chunks:
            self.kinds += np.bincount(chunk["kind"], minlength=len(Kind))
            self.last_requester = max(self.last_requester, int(chunk["requester"].max()))
            yield chunk


def level_named(machine: PhaseMachine, name: str) -> int:
    """Index of the first cache of that name, or at that level: l1 is the cores', l2 the next. ArchsimError if none."""
    names = dict.fromkeys(machine.cache_names)
    for number, known in enumerate(names):
        if name in (known, f"l{number + 1}"):
            return machine.cache_names.index(known)
    levels = [*names, *(f"l{number + 1}" for number in range(len(names)))]
    hint = did_you_mean(name, levels) or f"there are: {', '.join(dict.fromkeys(levels))}"
    raise fail(f"the machine has no level '{name}'", hint=hint)


def replay_without_time(name: str, reopen: Reopen, machine: PhaseMachine, cache: int, flush: bool) -> Replay:
    """Counts as Dinero IV makes them: every access is finished before the next; `flush` writes dirty lines back."""
    path = path_from(machine, cache)
    chain, census = new_chain([machine.spec.caches[k] for k in path]), Census()
    for chunk in census.watch(reopen()):
        addresses, sizes = np.ascontiguousarray(chunk["address"]), chunk["bytes"].astype(np.int64)
        replay_chain(chain, addresses, sizes, chunk["kind"] == Kind.WRITE)
    if census.last_requester > 0 and machine.cache_names.count(machine.cache_names[cache]) > 1:
        what = f"the trace has requesters up to {census.last_requester}, and '{machine.cache_names[cache]}' is private"
        raise fail(what, hint="leave out --functional, or name a shared level with --to")
    if flush:
        copy_back(chain)

    counts = counts_of(chain)
    names = _both_names([machine.cache_names[k] for k in path])
    statistics = measured("trace", TRACE, census.kinds)
    for level, number in names:
        statistics += measured(level, LEVEL, counts[number])
    statistics += measured("dram", MEMORY, counts[-1])
    return replay_of(name, statistics, [], _wanted([machine.cache_names[k] for k in path], ["requests"]))


class Play(NamedTuple):
    """How a trace is replayed with time."""

    model: str
    num_outstanding: int  # accesses of a trace with one requester that may be under way
    progress: Progress


def replay_with_time(name: str, reopen: Reopen, machine: PhaseMachine, cache: int, how: Play) -> Replay:
    """Every requester makes its accesses in order, the next when the one before has been answered."""
    census = Census()
    for _ in census.watch(reopen()):
        pass
    line_bytes = machine.spec.caches[cache].line_bytes
    if census.last_requester == 0:
        core = machine.spec.core._replace(
            num_cores=1, num_threads=how.num_outstanding, task_order=int(TaskOrder.FIRST_FREE)
        )
        machine, work = entered_at(machine, cache, core), dealt_work(reopen, line_bytes)
    else:
        machine = _with_requesters(machine, cache, census.last_requester + 1)
        num_threads = machine.spec.core.num_cores * machine.spec.core.num_threads
        work = requesters_work(reopen, line_bytes, num_threads)

    counters = play(how.model, machine.spec, work, lambda done, all_: how.progress("replaying", done, all_))
    return _timed_result(name, machine, counters, census)


def _with_requesters(machine: PhaseMachine, cache: int, num_requesters: int) -> PhaseMachine:
    """The machine with a thread for each requester: those of its cores, or, further down, a core for each."""
    core = machine.spec.core
    if cache != machine.spec.core_cache[0]:
        return entered_at(
            machine, cache, CoreSpec(num_requesters, 1, core.period_ticks, TaskOrder.INTERLEAVED)
        )
    if num_requesters > core.num_cores * core.num_threads:
        threads = f"{core.num_cores} x {core.num_threads} threads"
        raise fail(f"the trace has requesters up to {num_requesters - 1}; the cores have {threads}")
    spec = machine.spec._replace(
        core=core._replace(task_order=int(TaskOrder.INTERLEAVED)), source=UnitSpec(0)
    )
    return machine._replace(spec=spec)


def _timed_result(name: str, machine: PhaseMachine, counters: Counters, census: Census) -> Replay:
    view = PhaseView(machine, counters)
    distinct = list(dict.fromkeys(machine.cache_names))
    names = _both_names(distinct)
    statistics = measured("trace", TRACE, census.kinds) + measured("replay", REPLAY, (view, census.kinds))
    for level, number in names:
        members = [k for k, other in enumerate(machine.cache_names) if other == distinct[number]]
        statistics += measured(level, CACHES, CacheView(view, members))
    statistics += measured("dram", DRAM, DramView(view)) + measured(
        "dram", SPEED, speed_below_caches(DramView(view))
    )
    dram = ["requests", "row_hits", "row_misses", "row_conflicts", "gigabytes_per_second", "peak_percent"]
    wanted = ["replay.cycles", *_wanted(distinct, dram)]
    return replay_of(name, statistics, phase_checks("replay", machine, counters), wanted)


def _wanted(levels: list[str], dram: list[str]) -> list[str]:
    """Statistics for the summary."""
    found = [f"{level}.{what}" for level in levels for what in ("accesses", "hits", "misses", "writebacks")]
    return ["trace.accesses", *found, *(f"dram.{what}" for what in dram)]


def _both_names(names: list[str]) -> list[tuple[str, int]]:
    """(name, position) of each level, by its component and, where no component is called so, as l1, l2, ..."""
    levels = [(f"l{number + 1}", number) for number in range(len(names)) if f"l{number + 1}" not in names]
    return sorted(
        [*((name, number) for number, name in enumerate(names)), *levels], key=lambda level: level[1]
    )


def replay_of(
    name: str,
    statistics: list[Statistic],
    checks: list[Check],
    wanted: list[str],
    latency: Sequence[Bucket] = (),
) -> Replay:
    """A replay whose summary are the `wanted` statistics."""
    values = {statistic.name: statistic.value for statistic in statistics}
    summary = {name: values[name] for name in wanted} | {"checks_passed": all(check.ok for check in checks)}
    return Replay(name, summary, statistics, checks, list(latency))
