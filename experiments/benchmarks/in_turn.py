"""How fast checkouts of archsim play the same work, in turn, so that what else runs on the computer slows all alike.

Run: python experiments/benchmarks/in_turn.py FOLDER FOLDER... [--rounds N]      (default: 20; a minute or two each)

Each folder is the root of a checkout; the first is what the others are compared with. Printed are, of each phase, the
simulated instructions a second of the fastest round, and over the first checkout the ratio of the fastest rounds and
the median of the rounds' ratios. On a computer that others share, believe a change of which both say the same.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import IO, NamedTuple, cast

PLAYER = "--player"


class Checkout(NamedTuple):
    """A process that plays with the code of one checkout, and what it said: the phases, the seconds of each round."""

    folder: Path
    process: subprocess.Popen[str]
    instructions: dict[str, int]
    digest: str  # of all counters
    seconds: dict[str, list[float]]

    def play(self, name: str) -> None:
        """Play a phase once more."""
        orders, answers = cast(IO[str], self.process.stdin), cast(IO[str], self.process.stdout)
        print(name, file=orders, flush=True)
        self.seconds[name].append(float(answers.readline()))


def started(folder: Path) -> Checkout:
    """A player with this checkout's code, when it has compiled and played everything once."""
    process = subprocess.Popen(
        [sys.executable, __file__, PLAYER],
        env={**os.environ, "PYTHONPATH": str(folder.resolve())},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    digest, *phases = cast(IO[str], process.stdout).readline().split()
    instructions = {name: int(count) for name, count in (phase.split("=") for phase in phases)}
    return Checkout(folder, process, instructions, digest, {name: [] for name in instructions})


def player() -> None:
    """Say what there is to play; then play phases as they are named."""
    from phases import phases

    there = {phase.name: phase for phase in phases()}
    digest = hashlib.sha256(repr([phase.play() for phase in there.values()]).encode()).hexdigest()
    print(digest[:12], *(f"{phase.name}={phase.instructions}" for phase in there.values()), flush=True)
    for line in sys.stdin:
        began = time.perf_counter()
        there[line.strip()].play()
        print(time.perf_counter() - began, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--rounds", type=int, default=20)
    asked = parser.parse_args()
    checkouts = [started(folder) for folder in asked.folders]
    same = len({checkout.digest for checkout in checkouts}) == 1
    print("all counters are the same" if same else "COUNTERS DIFFER")
    for number in range(asked.rounds):
        for name in checkouts[0].seconds:
            for checkout in checkouts if number % 2 else reversed(checkouts):
                checkout.play(name)

    for name, first in checkouts[0].seconds.items():
        for checkout in checkouts:
            own = checkout.seconds[name]
            speed = checkout.instructions[name] / min(own) / 1e6
            median = statistics.median(a / b for a, b in zip(first, own, strict=True))
            print(f"{name:12}{speed:7.1f} M/s {min(first) / min(own):6.3f} {median:6.3f}  {checkout.folder}")


if __name__ == "__main__":
    player() if PLAYER in sys.argv else main()
