"""What if a part of the machine cost nothing? Each part made ideal in turn, and in pairs, as points of a sweep.

An ideal part is a machine configuration like any other, so that what is measured can be repeated with `--set`.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from archsim.config import LoadedSweep, RunConfig, sweep_of
from archsim.config.components import CacheConfig, CoreConfig, FifoConfig, LocksConfig, UnitConfig
from archsim.config.dram import DramConfig
from archsim.config.machine import MachineConfig
from archsim.config.stages import DelayStreamConfig, StageConfig
from archsim.errors import fail
from archsim.sweep.expand import flow
from archsim.units import format_bytes, format_frequency

_PLENTY = 1024  # MSHRs, targets and ports that nobody can use up
_MANY = 256  # accesses under way of a unit or a delay stream
_MORE_THREADS = 16
_LARGER = 64
_MOST_THREADS, _LARGEST = 4096, 2**40

Overrides = dict[str, Any]


class Outcome(NamedTuple):
    """One idea, measured."""

    ideas: tuple[str, ...]  # () is the machine as it is
    cycles: dict[str, float]  # of every phase
    speedup: float  # cycles of all phases as it is, over those with the idea


def ideal_parts(config: RunConfig) -> dict[str, Overrides]:
    """Idea -> the values that make a part of the run's machine ideal."""
    machine = config.machine
    stages = machine.all_of(StageConfig)
    found = {
        "perfect L1": dict(_perfect_first_level(machine)),
        "perfect L2": dict(_perfect_second_level(machine)),
        "infinite DRAM bandwidth": dict(_unlimited_dram(machine)),
        "no refresh": dict(_no_refresh(machine)),
        "unlimited misses under way": _caches(machine, ("mshrs", "targets")),
        "unlimited cache ports": _caches(machine, ("ports",)),
        "zero lock cost": {_key(name, "ideal"): True for name in machine.all_of(LocksConfig)},
        "ideal rasterizer": {
            _key(name, "interval_cycles"): 0
            for name, unit in machine.all_of(UnitConfig).items()
            if unit.interval_cycles > 0
        },
        f"{_MORE_THREADS} times the threads": {
            _key(name, "threads"): min(core.threads * _MORE_THREADS, _MOST_THREADS)
            for name, core in machine.all_of(CoreConfig).items()
        },
        **{f"ideal {name}": _ideal_stage(name, stage) for name, stage in stages.items()},
        "instant memory": dict(_instant_memory(machine)) if stages else {},
        "unlimited accesses under way": _unlimited_accesses(machine),
        "unlimited fifos": {_key(name, "entries"): _PLENTY for name in machine.all_of(FifoConfig) if stages},
    }
    return {idea: overrides for idea, overrides in found.items() if overrides}


def whatif_sweep(config: RunConfig, run: str, pairs: bool) -> tuple[LoadedSweep, list[tuple[str, ...]]]:
    """The sweep that measures every idea, and the ideas of each of its points."""
    ideas = ideal_parts(config)
    chosen: list[tuple[str, ...]] = [(), *((idea,) for idea in ideas)]
    if pairs:
        chosen += itertools.combinations(ideas, 2)
    distinct = {
        flow(_together(ideas, each)): each for each in reversed(chosen)
    }  # a pair may be one of the two
    chosen = [each for each in chosen if each in distinct.values()]
    points = [_together(ideas, each) for each in chosen]
    keys = {"name": f"whatif {config.name}"[:100], "run": run, "parameters": [{"list": points}]}
    return sweep_of(keys, "archsim whatif"), chosen


def outcomes(chosen: list[tuple[str, ...]], cycles: list[Mapping[str, float] | None]) -> list[Outcome]:
    """Every idea that could be measured, the largest speed-up first; `cycles` of phases for each point."""
    if not cycles or cycles[0] is None:
        raise fail("the machine as it is could not be measured")
    before = sum(cycles[0].values())
    found = [
        Outcome(ideas, dict(each), before / max(sum(each.values()), 1))
        for ideas, each in zip(chosen, cycles, strict=True)
        if each is not None
    ]
    return sorted(found, key=lambda outcome: -outcome.speedup)


def _together(ideas: Mapping[str, Overrides], chosen: tuple[str, ...]) -> Overrides:
    """The values of several ideas; a part that one of them replaces has no values of its own any more."""
    merged: Overrides = {}
    for idea in chosen:
        merged |= ideas[idea]
    replaced = tuple(f"{key}." for key, value in merged.items() if isinstance(value, dict))
    return {key: value for key, value in merged.items() if not key.startswith(replaced)}


def _perfect_first_level(machine: MachineConfig) -> Iterator[tuple[str, Any]]:
    """First-level caches 64 times as large, without limits; a line's first access costs a few cycles more."""
    first = _first_level(machine)
    for name, cache in machine.all_of(CacheConfig).items() if first else ():
        yield from _unlimited(name)
        if name in first:
            yield _key(name, "size"), format_bytes(_larger(cache.size))
        else:
            yield _key(name, "hit_cycles"), 1
    yield from _instant_drams(machine, first)


def _perfect_second_level(machine: MachineConfig) -> Iterator[tuple[str, Any]]:
    """Second-level caches without limits, before a memory that answers in one cycle of theirs."""
    first = _first_level(machine)
    second = {c.next for c in first.values() if machine.find(c.next, CacheConfig) is not None}
    for name in sorted(second):
        yield from _unlimited(name)
    if second:
        yield from _instant_drams(machine, first)


def _unlimited(cache: str) -> Iterator[tuple[str, Any]]:
    for key in ("mshrs", "targets", "ports"):
        yield _key(cache, key), _PLENTY


def _instant_drams(machine: MachineConfig, first: Mapping[str, CacheConfig]) -> Iterator[tuple[str, Any]]:
    """Every DRAM replaced by a memory whose clock is as fast as the caches', and that answers after one of its
    cycles.
    """
    for cache in list(first.values())[:1]:
        yield from _instant_memory(machine)
        for dram in machine.all_of(DramConfig).values():
            yield _clock(dram.clock), format_frequency(machine.clocks[cache.clock])


def _unlimited_dram(machine: MachineConfig) -> Iterator[tuple[str, Any]]:
    """Every DRAM replaced by one with the latency of a row hit and no limit to its bandwidth."""
    for name, dram in machine.all_of(DramConfig).items():
        yield (
            _key(name),
            {
                "kind": "ideal_dram",
                "clock": dram.clock,
                "size": format_bytes(dram.capacity_bytes),
                "latency_clocks": dram.timing.n_cl + dram.burst_beats // dram.data_rate,
            },
        )
        yield _clock(dram.clock), format_frequency(machine.clocks[dram.clock])


def _ideal_stage(name: str, stage: StageConfig) -> Overrides:
    """A unit that takes a task every cycle, computes it in one and passes it on in the next."""
    fastest = {"interval_cycles": 1, "latency_cycles": 1, "lanes": _PLENTY}
    return {_key(name, key): value for key, value in fastest.items() if getattr(stage, key) != value}


def _unlimited_accesses(machine: MachineConfig) -> Overrides:
    """Units and delay streams that need not wait for their accesses before they ask for more."""
    asking = [name for name, stage in machine.all_of(StageConfig).items() if stage.memory is not None]
    streams = list(machine.all_of(DelayStreamConfig))
    in_flight = {_key(name, "in_flight"): _MANY for name in asking}
    return {**in_flight, **{_key(name, "outstanding"): _MANY for name in (*asking, *streams)}}


def _instant_memory(machine: MachineConfig) -> Iterator[tuple[str, Any]]:
    """Every DRAM replaced by a memory that answers in its next clock."""
    for name, dram in machine.all_of(DramConfig).items():
        size = format_bytes(dram.capacity_bytes)
        yield _key(name), {"kind": "ideal_dram", "clock": dram.clock, "size": size, "latency_clocks": 1}
        yield _clock(dram.clock), format_frequency(machine.clocks[dram.clock])


def _no_refresh(machine: MachineConfig) -> Iterator[tuple[str, Any]]:
    for name, dram in machine.all_of(DramConfig).items():
        if dram.timing.n_refi:
            yield _key(name, "timing.n_refi"), 0


def _caches(machine: MachineConfig, keys: tuple[str, ...]) -> Overrides:
    return {_key(name, key): _PLENTY for name in machine.all_of(CacheConfig) for key in keys}


def _first_level(machine: MachineConfig) -> dict[str, CacheConfig]:
    """The caches that cores talk to."""
    names = dict.fromkeys(core.memory for core in machine.all_of(CoreConfig).values())
    return {name: cache for name in names if (cache := machine.find(name, CacheConfig)) is not None}


def _larger(size: int) -> int:
    return size * _LARGER if size * _LARGER <= _LARGEST else size


def _key(component: str, key: str = "") -> str:
    return f"machine.components.{component}" + (f".{key}" if key else "")


def _clock(name: str) -> str:
    return f"machine.clocks.{name}"
