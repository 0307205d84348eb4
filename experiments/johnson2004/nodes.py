"""Do the nodes that a drawn workload visits explain its cycles? Table 1 does not fix them. As Markdown.

Run: python experiments/johnson2004/nodes.py [--seeds N] [ROW ...]      (default: the drawn Doom light 1, 8 seeds)

A row is drawn with several seeds, with larger patches and, since the paper rounds table 1, with its count of grid
fragments behind the stencil at both ends of what is printed. A line is then fitted to cycles a sample over nodes a hit
and read where the paper's own useful cycles put the nodes. No run reads that number.
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np
from sensitivity import DRAWN, PHASES, load_row, played, printed, tables

from archsim.errors import ArchsimError
from archsim.machine.counters import Counters
from archsim.run.izb_work import record

ROW = "drawn_doom_light1"
FRAGMENT, NODE, HIT = 5, 7, 2  # instructions of izb_raster.s
NUM_PROCESSORS = 4
ROUNDING = 5_000  # half of the last digit of table 1's fragments
PATCHES = ([32, 32], [128, 128], [320, 256])


class Visited(NamedTuple):
    """What came out of one drawing."""

    nodes_per_hit: float
    cycles_per_hit: float
    useful_percent: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", nargs="*", default=[ROW])
    parser.add_argument("--seeds", type=int, default=8)
    options = parser.parse_args()
    print("| row | drawn with | nodes a hit | raster cycles a sample | useful % |")
    print("|---|---|---|---|---|")
    for row in options.rows:
        show_row(row, options.seeds)


def show_row(row: str, num_seeds: int) -> None:
    """Every drawing, the seeds' mean, and what the line through all says where the paper is."""
    seeds = [show(row, f"seed {seed}", [f"seed={seed}"]) for seed in range(num_seeds)]
    others = [show(row, name, overrides) for name, overrides in variants(row)]
    drawn = [visited for visited in seeds if visited]
    mean, spread = np.mean(drawn, axis=0), np.std(drawn, axis=0, ddof=1)
    cells = [f"{middle:.2f} ± {deviation:.2f}" for middle, deviation in zip(mean, spread, strict=True)]
    print(f"| {row} | mean of the seeds | " + " | ".join(cells) + " |")

    wanted, raster = nodes_of_the_paper(row), printed(row)[1]
    slope, start, error = line([*drawn, *(visited for visited in others if visited)])
    read = f"{start + slope * wanted:.2f} ± {error:.2f}"
    print(f"| {row} | line through all | {wanted:.2f} | {read} | |")
    print(
        f"| {row} | *printed* | {wanted:.2f} | {raster['cycles_per_tri_sample']} | {raster['useful_percent']} |",
        flush=True,
    )


def variants(row: str) -> list[tuple[str, list[str]]]:
    """(name, overrides) of what else table 1 leaves open, with the first seed."""
    post = int(tables()["table1_workload"][row.removeprefix(DRAWN)]["grid_fragments_M"]["post"] * 1e6 + 0.5)
    ends = (post - ROUNDING, post + ROUNDING)
    return [
        *(
            (f"{end:,} fragments behind the stencil", [f"workload.grid_fragments_post_stencil={end}"])
            for end in ends
        ),
        *((f"patches of {patch[0]} x {patch[1]}", [f"workload.patch={patch}"]) for patch in PATCHES),
    ]


def show(row: str, name: str, overrides: list[str]) -> Visited | None:
    """Draw, play the raster phase, print a line; None if no such workload can be drawn."""
    config = load_row(row, overrides)
    try:
        (work,) = record(config)
    except ArchsimError as error:
        print(f"| {row} | {name} | {error} | | |", flush=True)
        return None
    visited = visited_in(played(config, work, PHASES[1])[1])
    print(f"| {row} | {name} | " + " | ".join(f"{value:.2f}" for value in visited) + " |", flush=True)
    return visited


def visited_in(counters: Counters) -> Visited:
    """Nodes from the kernel's instructions."""
    hits, issued = int(counters.emitted.sum()), int(counters.useful.sum())
    nodes = nodes_of(issued, int(counters.tasks.sum()), hits)
    return Visited(nodes / hits, counters.cycles / hits, 100 * issued / (NUM_PROCESSORS * counters.cycles))


def nodes_of(issued: float, fragments: float, hits: float) -> float:
    """Nodes visited, of a kernel that issued so many instructions."""
    return (issued - FRAGMENT * fragments - HIT * hits) / NODE


def nodes_of_the_paper(row: str) -> float:
    """Nodes a hit that the paper's useful cycles (table 4) and fragments (table 1) come to."""
    workload, (_, raster) = tables()["table1_workload"][row.removeprefix(DRAWN)], printed(row)
    issued = NUM_PROCESSORS * raster["cycles"] * raster["useful_percent"] / 100
    hits = 1e6 * workload["framebuffer_fragments_M"]["pre_z"]
    return nodes_of(issued, 1e6 * workload["grid_fragments_M"]["post"], hits) / hits


def line(drawings: list[Visited]) -> tuple[float, float, float]:
    """Slope and start of cycles a hit over nodes a hit, and the standard deviation of what the line leaves."""
    nodes, cycles = np.array([each[:2] for each in drawings]).T
    slope, start = np.polyfit(nodes, cycles, 1)
    return float(slope), float(start), float(np.std(cycles - start - slope * nodes, ddof=2))


if __name__ == "__main__":
    main()
