"""archsim's DRAM beside Ramulator 2: the same requests and timing; clocks, latency and commands, as Markdown.

Run: python experiments/peers/ramulator.py BINARY      (minutes)

BINARY is a `ramulator2`. --dram and --trace choose, repeatedly. --set changes our DRAM (`dram.queue_entries=36`): that
is how the differences were explained. --at-once is for a Ramulator 2 that takes as many requests in a clock as there is
room for.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import dram
import numpy as np
import ramulator2
import traces

from archsim.model.dram.commands import Command
from archsim.model.dram.spec import DramSpec
from archsim.run.replay_dram import replay_on_dram
from archsim.trace.accesses import Kind

DRAMS = ("ddr4_2400", "ddr4_3200")
NEAREST = (  # to its address map, its buffers and its watermarks
    "dram.address_map=row:bank:group:line:channel:offset",
    "dram.queue_entries=33",
    "dram.write_queue={entries: 33, high: 26, low: 6}",
)
NUM_SPARE = 200  # requests behind a trace, since Ramulator 2 stops when it has taken the last one


class Tally(NamedTuple):
    """What a simulator did until the last data of the trace moved."""

    clocks: int
    read_latency: float | None  # clocks, mean; None without reads, or if waiting writes answered some
    reads: int  # commands
    writes: int
    activates: int
    refreshes: int
    row_hits: int  # column commands that are not the first of their row
    broken_rules: int  # of the data sheet, as the referee counts them


def played(spec: DramSpec) -> Iterator[tuple[str, np.ndarray]]:
    """The traces by name; their requests are made at even intervals."""
    for name, requests in dram.played(spec):
        intervals = np.unique(np.diff(requests["cycle"]))
        if len(intervals) == 1 and "unmerged" not in name:
            yield name, requests


def with_spare(requests: np.ndarray, spec: DramSpec) -> tuple[np.ndarray, int]:
    """The trace, one request in so many clocks, with reads and writes of a row of their own behind it."""
    interval_clocks = max(1, int(requests["cycle"][1] - requests["cycle"][0]))
    number = np.arange(NUM_SPARE)
    row, lines = _spare_row(spec) << spec.row.shift, number // 2 * traces.LINE_BYTES
    places = row + (number % 2 << spec.group.shift) + lines  # reads in one bank, writes in another
    found = np.concatenate([requests, traces.requests(places, number % 2 == 1)])
    found["cycle"] = np.arange(len(found)) * interval_clocks
    return found, interval_clocks


def _spare_row(spec: DramSpec) -> int:
    return (1 << spec.row.bits) - 1


def tally(
    commands: np.ndarray, memory: dram.Memory, requests: np.ndarray, read_latency: float, folder: Path
) -> Tally:
    """Count the commands up to the last column command of the trace; those of the spare row do not count."""
    spec = memory.part.spec
    num_reads = np.count_nonzero(requests["kind"] != Kind.WRITE) - NUM_SPARE // 2
    is_spare = commands["row"] == _spare_row(spec)
    is_column = np.isin(commands["command"], ramulator2.COLUMN) & ~is_spare
    end = np.flatnonzero(is_column)[-1] + 1
    judged = dram.tally(commands[:end], memory, read_latency, folder)
    kept = commands[:end][~is_spare[:end]]
    number = np.bincount(kept["command"], minlength=len(Command))
    return Tally(
        clocks=judged.clocks,
        read_latency=read_latency if 0 < num_reads == number[Command.RD] else None,
        reads=int(number[Command.RD]),
        writes=int(number[Command.WR]),
        activates=int(number[Command.ACT]),
        refreshes=int(number[Command.REF]),
        row_hits=_row_hits(kept),
        broken_rules=judged.broken_rules,
    )


def _row_hits(commands: np.ndarray) -> int:
    """Column commands behind another one of the same ACT."""
    found, used = 0, set()
    for command, bank in commands[["command", "bank"]].tolist():
        if command == Command.ACT:
            used.discard(bank)
        elif command in ramulator2.COLUMN:
            found += bank in used
            used.add(bank)
    return found


def alike(mine: np.ndarray, other: np.ndarray) -> int:
    """Commands, from the first on, that are the same and as many clocks behind the first one."""
    count = min(len(mine), len(other))
    mine, other = mine[:count], other[:count]
    is_same = mine["clock"] - mine["clock"][0] == other["clock"] - other["clock"][0]
    for field in ("command", "bank", "column"):
        is_same &= mine[field] == other[field]
    is_same &= (mine["row"] == other["row"]) | (mine["command"] == Command.PRE)
    return count if is_same.all() else int(np.argmin(is_same))


def ours(memory: dram.Memory, requests: np.ndarray) -> ramulator2.Run:
    """As `archsim trace replay --to dram` plays them."""
    parts: list[np.ndarray] = []

    def take(commands: np.ndarray) -> None:
        parts.append(commands.copy())

    replayed = replay_on_dram("", iter([requests]), memory.part, "compiled", take)
    value = {statistic.name: statistic.value for statistic in replayed.statistics}
    return ramulator2.Run(np.concatenate(parts), value["dram.average_read_clocks"])


def row(trace: str, who: str, found: Tally, is_alike: str) -> str:
    cells = [
        "" if value is None else f"{value:.1f}" if isinstance(value, float) else f"{value:,}"
        for value in found
    ]
    return f"| {' | '.join([trace, who, *cells, is_alike])} |"


def main(options: argparse.Namespace) -> None:
    for name in options.dram or DRAMS:
        chosen = dram.memory(name, [*NEAREST, *options.set])
        spec = chosen.part.spec
        print(f"\n{name}, {' '.join(options.set)}\n")
        print(f"| trace | | {' | '.join(field.replace('_', ' ') for field in Tally._fields)} | alike |")
        print("|---" * (len(Tally._fields) + 3) + "|")
        for trace, requests in played(spec):
            if options.trace and trace not in options.trace:
                continue
            made, interval_clocks = with_spare(requests, spec)
            if options.at_once and interval_clocks == 1:
                made["cycle"] = 0
            with TemporaryDirectory() as folder:
                runs = [
                    ours(chosen, made),
                    ramulator2.run(options.binary, Path(folder), made, spec, interval_clocks),
                ]
                mine, other = (
                    tally(run.commands, chosen, made, run.read_latency, Path(folder)) for run in runs
                )
            number = min(len(run.commands) for run in runs)
            print(row(trace, "archsim", mine, ""))
            how_many = f"{alike(runs[0].commands, runs[1].commands):,} of {number:,}"
            print(row("", "Ramulator 2", other, how_many), flush=True)


if __name__ == "__main__":
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("binary", type=Path)
    parser.add_argument("--dram", action="append", choices=DRAMS)
    parser.add_argument("--trace", action="append")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE")
    parser.add_argument("--at-once", action="store_true")
    main(parser.parse_args())
