"""archsim's caches without time beside pycachesim, a cache simulator of others: every count, or what differs.

Run: python experiments/peers/caches.py [--all]      (needs pycachesim; a minute; --all prints the equal ones, too)
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
import traces

from archsim.config import load_machine
from archsim.machine.build import group_machine
from archsim.run.replay import replay_without_time
from archsim.trace.access_work import split
from archsim.trace.accesses import Kind


class Level(NamedTuple):
    """A cache that writes back and allocates writes, or that writes through and does not."""

    num_sets: int
    num_ways: int
    line_bytes: int
    policy: str  # lru or fifo, as both call it
    is_through: bool = False


class Counts(NamedTuple):
    """What one level did."""

    hits: int  # reads only where writes are not looked up alike: behind another level, and if they go through
    misses: int  # likewise, if writes go through
    writebacks: int  # and what is written through


class Found(NamedTuple):
    """What one simulator says of a trace."""

    levels: list[Counts]
    memory_reads: int


SHAPES = ((64, 1), (16, 4), (1, 64), (256, 1), (32, 8), (1, 256), (512, 2))  # sets and ways
NAMES = ("builder_l1", "l2")  # in the machine
PAIRS = (
    (Level(16, 2, 32, "lru"), Level(64, 4, 32, "lru")),
    (Level(64, 1, 32, "lru"), Level(1, 128, 64, "lru")),
    (Level(16, 2, 32, "fifo"), Level(64, 4, 32, "fifo")),
    (Level(1, 32, 16, "lru"), Level(64, 4, 128, "fifo")),
    (Level(1, 32, 32, "lru"), Level(64, 4, 128, "fifo")),
    (Level(8, 8, 64, "lru"), Level(128, 8, 64, "fifo")),
    (Level(64, 1, 32, "fifo"), Level(1, 128, 64, "fifo")),
    (Level(16, 2, 32, "fifo", is_through=True), Level(64, 4, 32, "fifo")),
    (Level(64, 1, 32, "fifo", is_through=True), Level(1, 128, 64, "fifo")),
)


def chains() -> Iterator[tuple[Level, ...]]:
    """Caches of one level and of two."""
    for line_bytes in (32, 64, 128):
        for policy in ("lru", "fifo"):
            yield from ((Level(*shape, line_bytes, policy),) for shape in SHAPES)
    yield from PAIRS


def overrides(levels: tuple[Level, ...]) -> list[str]:
    """The teaching machine with these as its last caches: as `archsim trace replay --machine tiny --set ...`."""
    found = []
    for name, level in zip(NAMES[-len(levels) :], levels, strict=True):
        values = {
            "size": f"{level.num_sets * level.num_ways * level.line_bytes} B",
            "ways": level.num_ways,
            "line": f"{level.line_bytes} B",
            "replacement": level.policy,
            "write_policy": "write_through" if level.is_through else "write_back",
            "write_allocate": "false" if level.is_through else "true",
        }
        found += [f"components.{name}.{key}={value}" for key, value in values.items()]
    return found


def ours(levels: tuple[Level, ...], made: np.ndarray) -> Found:
    """As `archsim trace replay --functional` counts, nothing flushed."""
    machine = group_machine(load_machine("machines/tiny.yaml", overrides(levels)), "builder")
    names = NAMES[-len(levels) :]
    first = machine.cache_names.index(names[0])
    replayed = replay_without_time("", lambda: iter([made]), machine, first, False)
    value = {statistic.name: statistic.value for statistic in replayed.statistics}
    each = zip(names, levels, strict=True)
    counts = [_counted(value, name, level, name != names[0]) for name, level in each]
    # a whole line that is written and misses is not read here; the peer reads it
    unread = value["l2.write_misses"] if len({level.line_bytes for level in levels}) < len(levels) else 0
    return Found(counts, value["dram.reads"] + unread * (not levels[0].is_through))


def _counted(value: dict[str, Any], name: str, level: Level, is_behind: bool) -> Counts:
    """What the peer counts of the level."""
    read_misses = value[f"{name}.read_misses"]
    read_hits = value[f"{name}.reads"] - read_misses
    if level.is_through:
        return Counts(read_hits, read_misses, value[f"{name}.writethroughs"])
    hits = read_hits if is_behind else value[f"{name}.hits"]
    return Counts(hits, value[f"{name}.misses"], value[f"{name}.writebacks"])


def theirs(cachesim: Any, levels: tuple[Level, ...], made: np.ndarray) -> Found:
    """As pycachesim counts. Where a store allocates it is a load and a store to it, since alone it uses no line."""
    below, caches = None, []
    for level in reversed(levels):
        below = cachesim.Cache(
            f"L{len(caches)}",
            *(level.num_sets, level.num_ways, level.line_bytes, level.policy.upper()),
            write_back=not level.is_through,
            write_allocate=not level.is_through,
            load_from=below,
            store_to=below,
        )
        caches.insert(0, below)
    memory = cachesim.MainMemory()
    memory.load_to(caches[-1])
    memory.store_from(caches[-1])
    simulator = cachesim.CacheSimulator(caches[0], memory)
    for num_bytes, run in groupby(_pieces(made, levels[0]), key=itemgetter(2)):
        simulator.loadstore([_operation(address, kind, levels[0]) for address, kind, _ in run], num_bytes)
    counts = [Counts(cache.HIT_count, cache.MISS_count, cache.EVICT_count) for cache in caches]
    return Found(counts, memory.LOAD_count)


def _operation(address: int, kind: int, first: Level) -> tuple[tuple[int] | None, tuple[int] | None]:
    """The loads and stores of one access."""
    if kind != Kind.WRITE:
        return (address,), None
    return None if first.is_through else (address,), (address,)


def _pieces(made: np.ndarray, first: Level) -> list[tuple[int, int, int]]:
    """(address, kind, bytes) of each access, or of its part in each line."""
    return split(made, first.line_bytes)[["address", "kind", "bytes"]].tolist()


def played() -> dict[str, np.ndarray]:
    """The traces by name."""
    tiny = traces.exported("tiny", "L1", [])
    light = traces.exported("izb_bloodprison_light0", "L1", ["scene.resolution=[96, 80]"])[:100_000]
    for made in (tiny, light):
        made["requester"] = 0
    return {
        "scattered": traces.scattered(50_000, 1 << 16, 1),
        "strided": traces.strided(50_000, 1036, 1 << 17),
        "favoured": traces.favoured(50_000, 1 << 18, 2),
        "tiny": tiny,
        "light": light,
    }


def shown(levels: tuple[Level, ...]) -> str:
    return " + ".join(f"{one.num_sets}x{one.num_ways}x{one.line_bytes} {one.policy}" for one in levels)


def main(print_all: bool) -> None:
    cachesim = importlib.import_module("cachesim")
    num_equal = num_all = 0
    print("| trace | caches (sets x ways x line bytes) | | level: hits, misses, write-backs | memory reads |")
    print("|---|---|---|---|---|")
    for name, made in played().items():
        for levels in chains():
            both = {"archsim": ours(levels, made), "pycachesim": theirs(cachesim, levels, made)}
            is_equal = both["archsim"] == both["pycachesim"]
            num_equal, num_all = num_equal + is_equal, num_all + 1
            for who, found in both.items():
                if print_all or not is_equal:
                    counts = "; ".join(", ".join(f"{each:,}" for each in one) for one in found.levels)
                    print(f"| {name} | {shown(levels)} | {who} | {counts} | {found.memory_reads:,} |")
    print(f"\n{num_equal} of {num_all} comparisons: every count equal")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--all", action="store_true")
    main(parser.parse_args().all)
