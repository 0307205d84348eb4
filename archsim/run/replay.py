"""Replay an address trace on the caches of a machine, without time; what every replay gives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from archsim.errors import did_you_mean, fail
from archsim.machine.build import PhaseMachine
from archsim.machine.entry import path_from
from archsim.model.cache.functional import copy_back, counts_of, new_chain
from archsim.model.cache.functional import replay as replay_chain
from archsim.run.measure import measured
from archsim.run.replay_statistics import LEVEL, MEMORY, TRACE
from archsim.run.result import Check, Statistic
from archsim.trace.access_work import Reopen
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
    names = both_names([machine.cache_names[k] for k in path])
    statistics = measured("trace", TRACE, census.kinds)
    for level, number in names:
        statistics += measured(level, LEVEL, counts[number])
    statistics += measured("dram", MEMORY, counts[-1])
    return replay_of(name, statistics, [], wanted_of([machine.cache_names[k] for k in path], ["requests"]))


def wanted_of(levels: list[str], dram: list[str]) -> list[str]:
    """Statistics for the summary."""
    found = [f"{level}.{what}" for level in levels for what in ("accesses", "hits", "misses", "writebacks")]
    return ["trace.accesses", *found, *(f"dram.{what}" for what in dram)]


def both_names(names: list[str]) -> list[tuple[str, int]]:
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
