"""What the choices that the paper leaves open do to its tables, as Markdown.

Run: python experiments/johnson2004/sensitivity.py [--shares] [ROW ...]      (default: two scenes and one drawn row)

Machines, orders and layouts, one changed at a time. The kernels are executed once for each picture; the same work is
then played on every machine. With --shares instead: how the raster kernel's 14 instructions could be shared between
grid fragment, node and hit, with the stalls of the machine as configured.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from archsim import resources
from archsim.config import RunConfig, load_run
from archsim.errors import ArchsimError
from archsim.machine.build import phase_machine
from archsim.machine.counters import Counters
from archsim.machine.play import play
from archsim.machine.spec import MachineSpec
from archsim.run.izb_work import Recorded, record, replay
from archsim.trace.records import Op, Tasks

ROWS = ("doom_light0", "knot_light0", "drawn_doom_light0")
DRAWN = "drawn_"
PHASES = ("izb_build", "izb_raster")
POINTS = 1_310_720
SHARES = ((5, 7, 2), (4, 7, 3), (3, 8, 3), (4, 8, 2), (3, 9, 2), (2, 10, 2))  # a fragment, a node, a hit
L1 = "machine.components.{cpu_l1,fragment_l1}"

MACHINES = {
    "as configured": [],
    "2 MSHRs in each L1": [f"{L1}.mshrs=2"],
    "4 MSHRs in each L1": [f"{L1}.mshrs=4"],
    "16 MSHRs in each L1": [f"{L1}.mshrs=16"],
    "8 targets in each L1": [f"{L1}.targets=8"],
    "16 targets in the L2": ["machine.components.l2.targets=16"],
    "32 MSHRs in the L2": ["machine.components.l2.mshrs=32"],
    "32 MSHRs, 16 targets in the L2, 8 targets in each L1: none is ever waited for": [
        "machine.components.l2.mshrs=32",
        "machine.components.l2.targets=16",
        f"{L1}.targets=8",
    ],
    "2 ports to the L2": ["machine.components.l2.ports=2"],
    "FCFS instead of FR-FCFS": ["machine.components.dram.scheduler=fcfs"],
    "channels above lines": ["machine.components.dram.address_map=row:bank:channel:line:offset"],
    "banks below lines": ["machine.components.dram.address_map=row:line:bank:channel:offset"],
    "no refresh": ["machine.components.dram.timing.n_refi=0"],
    "a fragment every 4 cycles": ["machine.components.rasterizer.interval_cycles=4"],
}
PICTURES = {
    "pixels tile by tile in memory": ["workload.pixel_layout=tiles"],
    "nodes from a pool": ["workload.node_layout=pool"],
    "list heads of 4 bytes": ["workload.head_bytes=4"],
    "pixel tiles dealt in blocks": ["workload.tile_order=block"],
    "pixels processed in scan lines": ["workload.pixel_tile=[64, 1]"],
    "pixel tiles of 16 x 4": ["workload.pixel_tile=[16, 4]"],
    "grid tiles of 1 x 1: row by row": ["workload.grid_tile=[1, 1]"],
    "grid tiles of 16 x 16": ["workload.grid_tile=[16, 16]"],
    "triangles in random order": ["workload.triangle_order=random"],
    "patches of 32 x 32": ["workload.patch=[32, 32]"],
}
ONLY_DRAWN = ("workload.triangle_order", "workload.patch")
LIST_ORDERS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "lists oldest first": lambda addresses: -np.arange(len(addresses)),
    "lists in random order": lambda addresses: (addresses // 16 * 2_654_435_761) % 2**32,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", nargs="*", default=ROWS)
    parser.add_argument("--shares", action="store_true")
    options = parser.parse_args()
    if options.shares:
        show_shares(options.rows)
    else:
        show_changes(options.rows)


def show_changes(rows: Sequence[str]) -> None:
    """One choice changed at a time."""
    columns = "build cycles a point | useful % | L2 miss | raster cycles a sample | useful % | L2 miss"
    print(f"| row | changed | {columns} |")
    print("|---|---|---|---|---|---|---|---|")
    for row in rows:
        show_printed(row)
        (work,) = record(load_row(row))
        for name, overrides in MACHINES.items():
            show(row, name, load_row(row, overrides), work)
        for name, key in LIST_ORDERS.items():
            show(row, name, load_row(row), work._replace(raster=list(reordered(work.raster, key))))
        for name, overrides in PICTURES.items():
            if row.startswith(DRAWN) or not overrides[0].startswith(ONLY_DRAWN):
                show_picture(row, name, load_row(row, overrides))


def load_row(row: str, overrides: list[str] | None = None) -> RunConfig:
    """The run of a row; `{a,b}` in an override stands for both."""
    return load_run(resources.experiment("johnson2004") / f"{row}.yaml", list(both(overrides or [])))


def both(overrides: list[str]) -> Iterator[str]:
    for override in overrides:
        before, brace, rest = override.partition("{")
        inside, _, after = rest.partition("}")
        yield from (f"{before}{name}{after}" for name in inside.split(",")) if brace else (override,)


def tables() -> dict[str, Any]:
    """All that the paper prints."""
    found: dict[str, Any] = yaml.safe_load(
        (Path(__file__).parent / "printed.yaml").read_text(encoding="utf-8")
    )
    return found


def printed(row: str) -> list[dict[str, float]]:
    """The row of table 3 and that of table 4."""
    return [tables()[table][row.removeprefix(DRAWN)] for table in ("table3_build", "table4_raster")]


def show_printed(row: str) -> None:
    build, raster = printed(row)
    cells = [build["cycles_per_point"], build["useful_percent"], "75 - 118"]
    cells += [raster["cycles_per_tri_sample"], raster["useful_percent"], "75 - 118"]
    print(f"| {row} | *printed* | " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def reordered(chunks: list[Tasks], key: Callable[[np.ndarray], np.ndarray]) -> Iterator[Tasks]:
    """The same tasks, the nodes of every list visited in the order of a key of their addresses."""
    for tasks in chunks:
        records = tasks.records.copy()
        task = np.repeat(np.arange(tasks.num_tasks), np.diff(tasks.starts))
        nodes = np.flatnonzero((records["op"] == Op.LOAD) & (np.arange(len(task)) != tasks.starts[task]))
        addresses = records["address"][nodes]
        records["address"][nodes] = addresses[np.lexsort((key(addresses), task[nodes]))]
        yield Tasks(tasks.starts, records)


def show_picture(row: str, name: str, config: RunConfig) -> None:
    try:
        (work,) = record(config)
    except ArchsimError as error:
        print(f"| {row} | {name} | {error} | | | | | |", flush=True)
        return
    show(row, name, config, work)


def show(row: str, name: str, config: RunConfig, work: Recorded) -> None:
    """Play both phases and print a line."""
    columns = []
    for phase in PHASES:
        spec, counters = played(config, work, phase)
        slots = counters.cycles * spec.core.num_cores
        miss = counters.cache_fetch_ticks[-1] / counters.cache_fetches[-1] / spec.core.period_ticks
        each = counters.cycles / (POINTS if phase == PHASES[0] else counters.emitted.sum())
        columns += [f"{each:.2f}", f"{100 * counters.useful.sum() / slots:.2f}", f"{miss:.1f}"]
    print(f"| {row} | {name} | " + " | ".join(columns) + " |", flush=True)


def played(config: RunConfig, work: Recorded, phase: str) -> tuple[MachineSpec, Counters]:
    spec = phase_machine(config.machine, phase).spec
    return spec, play("compiled", spec, replay(work, phase, spec))


def show_shares(rows: Sequence[str]) -> None:
    """Raster cycles a sample if the instructions were shared in another way, at the same useful share of the slots."""
    print("| row | printed | " + " | ".join(f"{a} + {b} + {c}" for a, b, c in SHARES) + " |")
    print("|---|---|" + "---|" * len(SHARES))
    for row in rows:
        config = load_row(row)
        _, counters = played(config, record(config)[0], PHASES[1])
        fragments, hits = int(counters.tasks.sum()), int(counters.emitted.sum())
        issued = int(counters.useful.sum())
        nodes = (issued - 5 * fragments - 2 * hits) // 7
        per_instruction = counters.cycles / issued
        cells = [(a * fragments + b * nodes + c * hits) * per_instruction / hits for a, b, c in SHARES]
        wanted = printed(row)[1]["cycles_per_tri_sample"]
        print(f"| {row} | {wanted} | " + " | ".join(f"{cell:.2f}" for cell in cells) + " |", flush=True)


if __name__ == "__main__":
    main()
