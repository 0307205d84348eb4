"""archsim's caches without time, and with it, beside Dinero IV: every count of every level, or what differs.

Run: python experiments/peers/dinero.py DINERO_IV [--all]      (some minutes; --all prints the equal ones, too)

DINERO_IV is the command `dineroIV` of Dinero IV, version 7.
"""

from __future__ import annotations

import argparse
import re
import subprocess
from collections.abc import Iterator
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import traces

from archsim.config import load_machine
from archsim.machine.build import PhaseMachine, group_machine
from archsim.run.progress import silent
from archsim.run.replay import Replay, replay_without_time
from archsim.run.replay_timed import Play, replay_with_time
from archsim.trace.files import read_accesses, trace_writer
from archsim.trace.formats.languages import Format, format_named


class Level(NamedTuple):
    """A cache as both know it."""

    num_sets: int
    num_ways: int
    line_bytes: int
    policy: str = "lru"  # or fifo
    is_through: bool = False
    allocates: bool = True  # a write that misses
    num_sectors: int = 1  # of a line; Dinero's sub-blocks


class Counts(NamedTuple):
    """What one level did. Instruction fetches are reads."""

    reads: int
    writes: int  # those from above included
    read_misses: int
    write_misses: int
    bytes_read: int  # from the next level or the memory
    bytes_written: int


class File(NamedTuple):
    """A trace that both read."""

    path: Path
    form: Format
    num_accesses: int


NAMES = ("builder_l1", "l2")  # in the machine
SHAPES = ((64, 1), (16, 4), (1, 64), (256, 1), (32, 8), (1, 256), (512, 2))  # sets and ways
LINES = (16, 32, 64, 128)
POLICIES = ("lru", "fifo")
WRITES = ((False, True), (False, False), (True, True), (True, False))  # whether through, whether allocating
FIRST = (Level(16, 2, 32), Level(1, 32, 16, "fifo"), Level(64, 1, 32), Level(8, 8, 64))
SECOND = (Level(64, 4, 64), Level(1, 128, 64), Level(128, 1, 128, "fifo"), Level(32, 8, 128))
SECTORS = (
    Level(16, 4, 64, num_sectors=4),
    Level(1, 64, 128, "fifo", num_sectors=8),
    Level(256, 1, 32, num_sectors=2),
)


def chains() -> Iterator[tuple[Level, ...]]:
    """Caches of one level, with sectors, and of two levels; each with every way to write."""
    for shape, line_bytes, policy, writes in product(SHAPES, LINES, POLICIES, WRITES):
        yield (Level(*shape, line_bytes, policy, *writes),)
    for level, (is_through, allocates) in product(SECTORS, WRITES):
        yield (level._replace(is_through=is_through, allocates=allocates),)
    yield from pairs()


def pairs() -> Iterator[tuple[Level, ...]]:
    """Two levels: each first above each second, each way to write above each, now and then in sectors."""
    every = product(FIRST, SECOND, WRITES, WRITES)
    for number, (first, second, above, below) in enumerate(every):
        num_sectors = 2 if number % 5 == 0 else 1
        yield (
            first._replace(is_through=above[0], allocates=above[1]),
            second._replace(is_through=below[0], allocates=below[1], num_sectors=num_sectors),
        )


def machine_of(levels: tuple[Level, ...]) -> PhaseMachine:
    """The teaching machine with these as its last caches: as `archsim trace replay --machine tiny --set ...`."""
    changes = ["components.dram.channel_width=1 B"]  # so that a burst fits a sector
    for name, level in zip(NAMES[-len(levels) :], levels, strict=True):
        values = {
            "size": f"{level.num_sets * level.num_ways * level.line_bytes} B",
            "ways": level.num_ways,
            "line": f"{level.line_bytes} B",
            "sector": f"{level.line_bytes // level.num_sectors} B",
            "replacement": level.policy,
            "write_policy": "write_through" if level.is_through else "write_back",
            "write_allocate": str(level.allocates).lower(),
        }
        changes += [f"components.{name}.{key}={value}" for key, value in values.items()]
    return group_machine(load_machine("machines/tiny.yaml", changes), "builder")


def ours(levels: tuple[Level, ...], file: File, flush: bool) -> list[Counts]:
    """As `archsim trace replay --functional` counts, with --flush or --no-flush."""
    machine, names = machine_of(levels), NAMES[-len(levels) :]
    reopen = partial(read_accesses, file.path, file.form)
    replayed = replay_without_time("", reopen, machine, machine.cache_names.index(names[0]), flush)
    value = _values(replayed)
    return [Counts(*(value[f"{name}.{field}"] for field in Counts._fields)) for name in names]


def misses_with_time(levels: tuple[Level, ...], file: File) -> list[int]:
    """Of every level, as `archsim trace replay` counts them with one access under way at a time."""
    machine, names = machine_of(levels), NAMES[-len(levels) :]
    reopen = partial(read_accesses, file.path, file.form)
    how = Play("compiled", 1, silent)
    value = _values(replay_with_time("", reopen, machine, machine.cache_names.index(names[0]), how))
    return [value[f"{name}.misses"] for name in names]


def _values(replayed: Replay) -> dict[str, int]:
    return {statistic.name: int(statistic.value) for statistic in replayed.statistics}


def theirs(binary: Path, levels: tuple[Level, ...], file: File) -> tuple[list[Counts], list[Counts]]:
    """As Dinero IV counts: when the trace has ended, and when it has then written everything dirty back."""
    options = ["-informat", "d" if file.form.name == "dinero" else "D"]
    options += ["-stat-interval", str(file.num_accesses)]
    for number, level in enumerate(levels):
        values = {
            "size": level.num_sets * level.num_ways * level.line_bytes,
            "bsize": level.line_bytes,
            "sbsize": level.line_bytes // level.num_sectors,
            "assoc": level.num_ways,
            "repl": level.policy[0],
            "wback": "n" if level.is_through else "a",
            "walloc": "a" if level.allocates else "n",
        }
        for key, value in values.items():
            options += [f"-l{number + 1}-u{key}", str(value)]
    with file.path.open() as trace:
        done = subprocess.run([binary, *options], stdin=trace, capture_output=True, text=True, check=True)
    found = [_counted(part) for part in re.split(r"^l\d-ucache\n", done.stdout, flags=re.MULTILINE)[1:]]
    return found[: len(levels)], found[len(levels) :]


def _counted(text: str) -> Counts:
    """What it prints of a level."""
    rows = {name: [int(n) for n in re.findall(r"\d+", _line(text, name))] for name in ("Fetches", "Misses")}
    (_, code, _, reads, writes, others), (_, code_misses, _, read_misses, write_misses, other_misses) = (
        rows.values()
    )
    return Counts(
        reads=code + reads + others,
        writes=writes,
        read_misses=code_misses + read_misses + other_misses,
        write_misses=write_misses,
        bytes_read=int(_line(text, "Bytes From Memory")),
        bytes_written=int(_line(text, "Bytes To Memory")),
    )


def _line(text: str, name: str) -> str:
    """What is behind a name."""
    found = re.search(rf"^ (?:Demand )?{name}\s(.*)$", text, flags=re.MULTILINE)
    if found is None:
        raise ValueError(f"Dinero IV does not print '{name}'")
    return found[1]


def played() -> dict[str, np.ndarray]:
    """The traces by name."""
    tiny = traces.exported("tiny", "L1", [])
    light = traces.exported("izb_bloodprison_light0", "L1", ["scene.resolution=[96, 80]"])[:100_000]
    return {
        "scattered": traces.scattered(50_000, 1 << 16, 1),
        "strided": traces.strided(50_000, 1036, 1 << 17),
        "favoured": traces.favoured(50_000, 1 << 18, 2),
        "program": traces.program(50_000, 3),
        "ragged": traces.ragged(20_000, 1 << 16, 200, 4),
        "tiny": tiny,
        "light": light,
    }


def written(name: str, made: np.ndarray, folder: Path) -> File:
    """The trace as a file: `din`, or `xdin` if not all of it are words."""
    is_words = np.all(made["bytes"] == traces.WORD_BYTES) and not np.any(made["address"] % traces.WORD_BYTES)
    form = format_named("dinero" if is_words else "xdin")
    path = folder / f"{name}.{form.name}"
    with trace_writer(path, form) as writer:
        writer.write(made)
    return File(path, form, len(made))


def shown(levels: tuple[Level, ...]) -> str:
    return " + ".join(
        f"{one.num_sets}x{one.num_ways}x{one.line_bytes}/{one.num_sectors} {one.policy}"
        f" {'through' if one.is_through else 'back'}{'' if one.allocates else ', no allocation'}"
        for one in levels
    )


class Score:
    """Comparisons made; prints those that differ, or all."""

    def __init__(self, print_all: bool) -> None:
        self.print_all, self.num_equal, self.num_all = print_all, 0, 0

    def compare(self, what: str, mine: list, other: list) -> None:
        self.num_all += 1
        self.num_equal += mine == other
        if self.print_all or mine != other:
            for who, found in (("archsim", mine), ("Dinero IV", other)):
                print(f"| {what} | {who} | {'; '.join(_numbers(one) for one in found)} |", flush=True)


def _numbers(found: Counts | int) -> str:
    return ", ".join(f"{each:,}" for each in ([found] if isinstance(found, int) else found))


def main(binary: Path, print_all: bool) -> None:
    print("| trace | caches (sets x ways x line bytes / sectors) | | | each level |")
    print("|---|---|---|---|---|")
    without_time, with_time = Score(print_all), Score(print_all)
    with TemporaryDirectory() as folder:
        for name, made in played().items():
            file = written(name, made, Path(folder))
            for levels in chains():
                at_end, flushed = theirs(binary, levels, file)
                what = f"{name} | {shown(levels)}"
                without_time.compare(f"{what} | ", ours(levels, file, False), at_end)
                without_time.compare(f"{what} | flushed", ours(levels, file, True), flushed)
                if made["bytes"].max() < levels[0].line_bytes:
                    misses = [one.read_misses + one.write_misses for one in at_end]
                    with_time.compare(f"{what} | misses with time", misses_with_time(levels, file), misses)
    print(f"\n{without_time.num_equal} of {without_time.num_all} comparisons without time: every count equal")
    print(f"{with_time.num_equal} of {with_time.num_all} comparisons with time: misses of every level equal")


if __name__ == "__main__":
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("binary", type=Path)
    parser.add_argument("--all", action="store_true")
    options = parser.parse_args()
    main(options.binary, options.all)
