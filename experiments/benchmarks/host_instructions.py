"""Which functions of the compiled machine the host's instructions go into: a sampling profiler sees less in such code.

Run: python experiments/benchmarks/host_instructions.py PHASE [--chunks N] [--least F]     (some ten minutes)
PHASE is izb_build or izb_raster. Needs valgrind and addr2line (binutils).

Compiles `play` with debug information for a processor that valgrind knows, plays the first chunks of the phase under
callgrind, and adds up, for each place in the tree of inlined functions, per simulated instruction: instructions,
conditional branches and those that callgrind's simple predictor gets wrong, and misses of its caches of 32 KiB for
instructions and 48 KiB for data. The processor here predicts better and has wider vectors; use it to find what is
large, and `in_turn.py` to see what a change brings.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

PLAYER = "--player"
CALLGRIND = ["valgrind", "--tool=callgrind", "--dump-instr=yes", "--cache-sim=yes", "--branch-sim=yes"]
CACHES = ["--I1=32768,8,64", "--D1=49152,12,64", "--LL=2097152,16,64"]
PROCESSOR = {
    "NUMBA_CPU_NAME": "haswell",
    "NUMBA_CPU_FEATURES": "+sse4.2,+avx,+avx2,+bmi,+bmi2,+fma,+popcnt,+lzcnt,+movbe",
    "NUMBA_DEBUGINFO": "1",
}
COLUMNS = {
    "instructions": "Ir",
    "branches": "Bc",
    "mispredicted": "Bcm",
    "I1 misses": "I1mr",
    "D1 misses": "D1mr",
}
Costs = Counter[str]


def player(name: str, num_chunks: int, code: Path) -> None:
    """Play the first chunk, which compiles; write the compiled code and say where it lies; play all chunks."""
    from phases import phases

    from archsim.machine.loop import play
    from archsim.trace.records import num_instructions

    phase = next(phase for phase in phases() if phase.name == name)
    phase.play(1)
    cached = next(Path(play._cache.cache_path).glob("loop.play-*.nbc")).read_bytes()
    code.write_bytes(cached[cached.index(b"\x7fELF") :])
    phase.play(num_chunks)
    (compiled,) = play.overloads.values()
    address = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
    played = [*phase.chunks[:1], *phase.chunks[:num_chunks]]
    code.with_suffix(".txt").write_text(f"{address} {sum(map(num_instructions, played))}")


def costs_of(counts: Path) -> dict[int, Costs]:
    """What callgrind counted at each address: lines of an address and a line, absolute or relative, then the events."""
    costs: dict[int, Costs] = defaultdict(Counter)
    events: list[str] = []
    address, is_call = 0, False
    for line in counts.read_text().splitlines():
        if line.startswith("events:"):
            events = line.split()[1:]
        elif line.startswith("calls="):
            is_call = True
        elif line[:1] in set("0123456789+-*"):
            place, _, *values = line.split()
            if place[0] in "+-":
                address += int(place, 0)
            elif place != "*":
                address = int(place, 0)
            if not is_call:  # zeros at the end of a line are left out
                costs[address].update(dict(zip(events, map(int, values), strict=False)))
            is_call = False
    return costs


def inlined_at(code: Path, offsets: list[int]) -> Iterator[list[str]]:
    """For each offset the functions it was inlined through, the outermost first."""
    told = subprocess.run(
        ["addr2line", "-a", "-i", "-f", "-j", ".ltext", "-e", code],
        input="\n".join(map(hex, offsets)),
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    for block in re.split(r"^0x[0-9a-f]+\n", told, flags=re.MULTILINE)[1:]:
        yield [name_of(symbol) for symbol in reversed(block.splitlines()[::2])]


def name_of(symbol: str) -> str:
    """The last two names of a mangled one, the module's and the function's; empty for code that is not `play`'s."""
    names, place = [], 3
    while (length := re.match(r"\d+", symbol[place:])) is not None:
        place += length.end()
        names.append(symbol[place : place + int(length[0])])
        place += int(length[0])
    return ".".join(names[-2:])


def show(tree: dict[tuple[str, ...], Costs], path: tuple[str, ...], instructions: int, least: float) -> None:
    """The functions below one, those that cost most first, each with what it has inlined."""
    below = [one for one in tree if one[:-1] == path and tree[one]["Ir"] / instructions >= least]
    for one in sorted(below, key=lambda one: -tree[one]["Ir"]):
        values = "".join(f"{tree[one][event] / instructions:13.2f}" for event in COLUMNS.values())
        print(f"{'  ' * len(path) + one[-1]:70}{values}")
        show(tree, one, instructions, least)


def measured(phase: str, num_chunks: int) -> tuple[dict[tuple[str, ...], Costs], int]:
    """What each path of inlined functions costs with all below it, and the simulated instructions that were played."""
    with tempfile.TemporaryDirectory() as name:
        code, counts = Path(name) / "play.o", Path(name) / "callgrind.out"
        command = [sys.executable, __file__, PLAYER, phase, str(num_chunks), str(code)]
        # A cache of its own: numba does not tell code with debug information from code without.
        environment = {**os.environ, **PROCESSOR, "ARCHSIM_CACHE_DIR": name}
        # Compiles. Under valgrind that would take an hour.
        subprocess.run(command, env=environment, check=True)
        valgrind = [*CALLGRIND, *CACHES, f"--callgrind-out-file={counts}"]
        subprocess.run([*valgrind, *command], env=environment, check=True, capture_output=True)
        address, instructions = map(int, code.with_suffix(".txt").read_text().split())
        costs = {place - address: cost for place, cost in costs_of(counts).items() if place >= address}
        near = sorted(offset for offset in costs if offset < code.stat().st_size)
        tree: dict[tuple[str, ...], Costs] = defaultdict(Counter)
        for offset, names in zip(near, inlined_at(code, near), strict=True):
            for depth in range(1, len(names) + 1 if all(names) else 1):
                tree[tuple(names[:depth])].update(costs[offset])
    return tree, instructions


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("phase", choices=["izb_build", "izb_raster"])
    parser.add_argument("--chunks", type=int, default=1)
    parser.add_argument("--least", type=float, default=2.0, help="instructions per simulated one")
    asked = parser.parse_args()
    tree, instructions = measured(asked.phase, asked.chunks)
    print(f"{'per simulated instruction':70}{''.join(f'{title:>13}' for title in COLUMNS)}")
    show(tree, (), instructions, asked.least)


if __name__ == "__main__":
    if PLAYER in sys.argv:
        player(sys.argv[2], int(sys.argv[3]), Path(sys.argv[4]))
    else:
        main()
