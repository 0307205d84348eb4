"""How well two processes share a sweep of 40 points: the time of one over twice the time of two.

Run: python experiments/benchmarks/sweep_efficiency.py [PROCESSES]      (default: 2; some minutes, on an idle computer)
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import archsim

SWEEP = {
    "name": "efficiency",
    "run": "runs/izb_knot.yaml",
    "set": {"scene.resolution": [640, 512]},
    "parameters": [
        {
            "grid": {
                "machine.components.l2.size": ["32 KiB", "64 KiB", "128 KiB", "256 KiB", "512 KiB"],
                "machine.components.fragment_processors.threads": [1, 2, 4, 8],
                "machine.components.l2.ways": [4, 8],
            }
        }
    ],
    "metrics": ["izb_raster.cycles"],
}


def main(processes: int) -> None:
    seconds = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, jobs in (("compiling", processes), ("one", 1), ("all", processes)):
            started = time.perf_counter()
            points = len(archsim.sweep(SWEEP, Path(folder) / name, jobs).table)
            seconds[name] = time.perf_counter() - started
    efficiency = seconds["one"] / (processes * seconds["all"])
    print(f"{points} points: {seconds['one']:.1f} s in one process, {seconds['all']:.1f} s in {processes}")
    print(f"parallel efficiency {100 * efficiency:.0f} %")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:2] or ("2",)))
