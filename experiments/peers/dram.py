"""archsim's DRAM beside DRAMsim3: the same requests and timing; cycles, latency and commands, as Markdown.

Run: python experiments/peers/dram.py BINARY      (minutes)

BINARY is a dramsim3main that was built with -DCMD_TRACE=1. --dram and --trace choose, repeatedly. --set changes our
DRAM (`dram.queue_entries=16`), --peer the other's controller (`queue_structure=PER_BANK`): that is how the differences
were explained.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import dramsim3
import numpy as np
import traces

from archsim.config import load_machine
from archsim.config.dram import DramConfig
from archsim.machine.command_trace import written_commands
from archsim.model.dram.commands import Command
from archsim.model.dram.spec import DramSpec
from archsim.run.replay_dram import DramPart, dram_part, replay_on_dram
from archsim.trace.referee.commands import read_commands
from archsim.trace.referee.rules import violations

CLOCKS = {"ddr3_1600": "800 MHz", "ddr4_2400": "1200 MHz", "ddr4_3200": "1600 MHz"}
NUM_REQUESTS = 10_000
SPAN_BYTES = 1 << 30
SPARE_CLOCKS = 100_000  # that the peer may take longer


class Memory(NamedTuple):
    """A DRAM alone, as it is described and as it is simulated."""

    config: DramConfig
    part: DramPart


class Tally(NamedTuple):
    """What a simulator did until the last data moved."""

    clocks: int
    read_latency: float  # clocks, mean
    reads: int  # commands
    writes: int
    activates: int
    precharged: int  # rows closed
    refreshes: int
    row_hits: int  # column commands that are not the first of their row
    broken_rules: int  # of the data sheet, as the referee counts them


def memory(name: str, overrides: list[str]) -> Memory:
    """One of configs/dram, below caches with lines of 64 bytes."""
    changes = [f"components.dram={{base: dram/{name}.yaml}}", f"clocks.memory={CLOCKS[name]}"]
    changes += [f"components.{override}" for override in overrides]
    machine = load_machine("machines/ddr4_3200.yaml", changes)
    (config,) = machine.all_of(DramConfig).values()
    return Memory(config, dram_part(machine, None))


def played(spec: DramSpec) -> Iterator[tuple[str, np.ndarray]]:
    """The traces by name."""
    draw = np.random.default_rng(5)
    line = np.arange(NUM_REQUESTS) * traces.LINE_BYTES
    anywhere = traces.distinct_lines(NUM_REQUESTS, SPAN_BYTES, 3)
    yield "sequential reads", traces.requests(line)
    yield "sequential, 1/3 writes", traces.requests(line, draw.random(NUM_REQUESTS) < 1 / 3)
    yield "scattered reads", traces.requests(anywhere)
    yield "scattered, 1/3 writes", traces.requests(anywhere, draw.random(NUM_REQUESTS) < 1 / 3)
    yield "scattered writes", traces.requests(anywhere, True)
    yield "rows of one bank", traces.requests(np.arange(2_000) << spec.row.shift)
    yield "scattered reads, one in 100 clocks", traces.requests(anywhere[:4_000], interval_clocks=100)
    is_write = draw.random(NUM_REQUESTS) < 1 / 3
    yield "scattered, 1/3 writes, one in 20 clocks", traces.requests(anywhere, is_write, 20)
    tiny = traces.exported("tiny", "dram", [])
    light = traces.exported("izb_bloodprison_light0", "dram", ["scene.resolution=[96, 80]"])[:20_000]
    for name, run in (("tiny", tiny), ("light", light)):
        timed, hurried = traces.as_lines(run, is_hurried=False), traces.as_lines(run, is_hurried=True)
        yield name, timed
        yield f"{name}, unmerged", traces.unmerged(timed)
        yield f"{name}, unmerged, one a clock", traces.unmerged(traces.one_a_clock(timed))
        yield f"{name}, hurried", hurried
        yield f"{name}, hurried, unmerged", traces.unmerged(hurried)


def tally(commands: np.ndarray, memory: Memory, read_latency: float, folder: Path) -> Tally:
    """Count the commands up to the last column command."""
    spec = memory.part.spec
    is_column = np.isin(commands["command"], dramsim3.COLUMN)
    kept = commands[: np.flatnonzero(is_column)[-1] + 1]
    to_data = np.where(kept["command"] == Command.WR, spec.timing.n_wl, spec.timing.n_cl) + spec.burst_clocks
    ends = (kept["clock"] + to_data)[is_column[: len(kept)]]
    number = np.bincount(kept["command"], minlength=len(Command))
    precharged, row_hits = _rows(kept)
    return Tally(
        clocks=int(ends.max()),
        read_latency=read_latency,
        reads=int(number[Command.RD]),
        writes=int(number[Command.WR]),
        activates=int(number[Command.ACT]),
        precharged=precharged,
        refreshes=int(number[Command.REF]),
        row_hits=row_hits,
        broken_rules=_judged(kept, memory, folder),
    )


def _rows(commands: np.ndarray) -> tuple[int, int]:
    """Rows closed, and column commands that are not the first of their row."""
    precharged = row_hits = 0
    is_used: dict[int, bool] = {}  # of the banks that are open
    for command, bank in commands[["command", "bank"]].tolist():
        if command == Command.ACT:
            is_used[bank] = False
        elif command == Command.PRE:
            precharged += 1
            del is_used[bank]
        elif command == Command.PREA:
            precharged += len(is_used)
            is_used.clear()
        elif command in dramsim3.COLUMN:
            row_hits += is_used[bank]
            is_used[bank] = True
    return precharged, row_hits


def _judged(commands: np.ndarray, memory: Memory, folder: Path) -> int:
    """Rules broken: as `archsim trace check-dram` judges."""
    file = folder / "commands.csv"
    with written_commands(memory.part.spec, file) as sink:
        sink(commands)
    return sum(1 for _ in violations(memory.config, read_commands(file)))


def ours(memory: Memory, requests: np.ndarray, folder: Path) -> Tally:
    """As `archsim trace replay --to dram` plays them."""
    parts: list[np.ndarray] = []

    def take(commands: np.ndarray) -> None:
        parts.append(commands.copy())

    replayed = replay_on_dram("", iter([requests]), memory.part, "compiled", take)
    value = {statistic.name: statistic.value for statistic in replayed.statistics}
    return tally(np.concatenate(parts), memory, value["dram.average_read_clocks"], folder)


def theirs(
    peer: tuple[Path, dramsim3.Policy], memory: Memory, requests: np.ndarray, our_clocks: int, folder: Path
) -> Tally:
    """As DRAMsim3 plays them. ValueError if it does not do them all in twice our clocks and some."""
    binary, policy = peer
    clocks = 2 * our_clocks + SPARE_CLOCKS
    config = dramsim3.configuration(memory.part.spec, policy)
    run = dramsim3.run(binary, folder, config, requests, memory.part.spec, clocks)
    done = run.statistics["num_reads_done"] + run.statistics["num_writes_done"]
    if done != len(requests):
        raise ValueError(f"{done} of {len(requests)} requests done in {clocks} clocks")
    return tally(run.commands, memory, run.statistics["average_read_latency"], folder)


def row(trace: str, who: str, found: Tally) -> str:
    cells = [f"{value:.1f}" if isinstance(value, float) else f"{value:,}" for value in found]
    return f"| {' | '.join([trace, who, *cells])} |"


def main(options: argparse.Namespace) -> None:
    policy = dramsim3.Policy(**dict(change.split("=", 1) for change in options.peer))
    for name in options.dram or CLOCKS:
        chosen = memory(name, options.set)
        print(f"\n{name}, {' '.join([*options.set, *options.peer])}\n")
        print(f"| trace | | {' | '.join(field.replace('_', ' ') for field in Tally._fields)} |")
        print("|---" * (len(Tally._fields) + 2) + "|")
        for trace, requests in played(chosen.part.spec):
            if options.trace and trace not in options.trace:
                continue
            with TemporaryDirectory() as name_of_folder:
                folder = Path(name_of_folder)
                found = ours(chosen, requests, folder)
                other = theirs((options.binary, policy), chosen, requests, found.clocks, folder)
            print(row(trace, "archsim", found))
            print(row("", "DRAMsim3", other), flush=True)


if __name__ == "__main__":
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("binary", type=Path)
    parser.add_argument("--dram", action="append", choices=CLOCKS)
    parser.add_argument("--trace", action="append")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE")
    parser.add_argument("--peer", action="append", default=[], metavar="NAME=VALUE")
    main(parser.parse_args())
