"""What the choices that the paper leaves open do to its tables.

Run: python experiments/johnson2004/sensitivity.py [ROW ...]      (default: one scene and one drawn row)

First table: machines and orders, one changed at a time. The kernels are executed once for each picture; the
same work is then played on every machine. Second table: how the raster kernel's 14 instructions could be shared between
grid fragment, node and hit, with the stalls of the machine as configured.
"""

from __future__ import annotations

import sys

from archsim import resources
from archsim.config import RunConfig, load_run
from archsim.machine.build import phase_machine
from archsim.machine.counters import Counters
from archsim.machine.play import play
from archsim.run.izb_work import Recorded, record, replay

ROWS = ("knot_light0", "drawn_doom_light0")
DRAWN = "drawn_"
PHASES = ("izb_build", "izb_raster")
SHARES = ((5, 7, 2), (4, 7, 3), (3, 8, 3), (4, 8, 2), (3, 9, 2), (2, 10, 2))


def l1_mshrs(number: int) -> list[str]:
    return [f"machine.components.{cache}.mshrs={number}" for cache in ("cpu_l1", "fragment_l1")]


MACHINES = {
    "as configured: 8 MSHRs in each L1": [],
    "2 MSHRs in each L1": l1_mshrs(2),
    "4 MSHRs in each L1": l1_mshrs(4),
    "16 MSHRs in each L1": l1_mshrs(16),
    "8 MSHRs in the L2": ["machine.components.l2.mshrs=8"],
    "FCFS instead of FR-FCFS": ["machine.components.dram.scheduler=fcfs"],
    "channels above lines": ["machine.components.dram.address_map=row:bank:channel:line:offset"],
    "banks below lines": ["machine.components.dram.address_map=row:line:bank:channel:offset"],
    "no refresh": ["machine.components.dram.timing.n_refi=0"],
    "a fragment every 4 cycles": ["machine.components.rasterizer.interval_cycles=4"],
}
PICTURES = {
    "tiles in blocks": ["workload.tile_order=block"],
    "pixels in scan lines": ["workload.pixel_tile=[64, 1]"],
    "pixel tiles of 16 x 16": ["workload.pixel_tile=[16, 16]"],
    "grid tiles of 1 x 1: row by row": ["workload.grid_tile=[1, 1]"],
    "grid tiles of 16 x 16": ["workload.grid_tile=[16, 16]"],
    "triangles in random order": ["workload.triangle_order=random"],
}


def main() -> None:
    splits = []
    columns = "build cycles a point | useful % | L2 miss | raster cycles a sample | useful % | L2 miss"
    print(f"| row | changed | {columns} |")
    print("|---|---|---|---|---|---|---|---|")
    for row in sys.argv[1:] or ROWS:
        path = resources.experiment("johnson2004") / f"{row}.yaml"
        (work,) = record(load_run(path))
        for name, overrides in MACHINES.items():
            counters = show(row, name, load_run(path, overrides), work)
            if not overrides:
                splits.append((row, counters, work))
        for name, overrides in PICTURES.items():
            own = suitable(row, overrides)
            if own:
                config = load_run(path, own)
                show(row, name, config, record(config)[0])
    show_splits(splits)


def suitable(row: str, overrides: list[str]) -> list[str]:
    """The overrides that a row's kind of workload knows."""
    only_drawn = "workload.triangle_order"
    return [each for each in overrides if row.startswith(DRAWN) or not each.startswith(only_drawn)]


def show(row: str, name: str, config: RunConfig, work: Recorded) -> Counters:
    """Play both phases and print a line; the raster phase's counters."""
    columns = []
    for phase in PHASES:
        spec = phase_machine(config.machine, phase).spec
        counters = play("compiled", spec, replay(work, phase, spec))
        slots = counters.cycles * spec.core.num_cores
        miss = counters.cache_fetch_ticks[-1] / counters.cache_fetches[-1] / spec.core.period_ticks
        each = counters.cycles / (1310720 if phase == PHASES[0] else counters.emitted.sum())
        columns += [f"{each:.2f}", f"{100 * counters.useful.sum() / slots:.2f}", f"{miss:.1f}"]
    print(f"| {row} | {name} | " + " | ".join(columns) + " |", flush=True)
    return counters


def show_splits(rows: list[tuple[str, Counters, Recorded]]) -> None:
    """Raster cycles a sample if the instructions were shared in another way, at the same useful share of the slots."""
    print("\n| row | " + " | ".join(f"{a} + {b} + {c}" for a, b, c in SHARES) + " |")
    print("|---|" + "---|" * len(SHARES))
    for row, counters, _ in rows:
        fragments, hits = int(counters.tasks.sum()), int(counters.emitted.sum())
        issued = int(counters.useful.sum())
        nodes = (issued - 5 * fragments - 2 * hits) // 7
        per_instruction = counters.cycles / issued
        cells = [(a * fragments + b * nodes + c * hits) * per_instruction / hits for a, b, c in SHARES]
        print(f"| {row} | " + " | ".join(f"{cell:.2f}" for cell in cells) + " |")


if __name__ == "__main__":
    main()
