"""What the machine parameters that the paper does not print do to its tables.

Run: python experiments/johnson2004/sensitivity.py [ROW ...]      (default: all three rows)

The kernels are executed once for each row; the same work is then played on every variant of the machine.
"""

from __future__ import annotations

import sys

from archsim import resources
from archsim.config import load_run
from archsim.execute import izb_memory
from archsim.execute.izb_build import build_work, tile_order
from archsim.execute.izb_raster import raster_work
from archsim.machine.build import phase_machine
from archsim.machine.play import play
from archsim.raster.eye_view import eye_view
from archsim.run.izb import method_of
from archsim.scene.scene import load_scene
from archsim.shadow.plain import grid_fragments, plan_faces
from archsim.trace.records import Tasks
from archsim.trace.stream import Work

ROWS = ("doom_light0", "doom_light1", "knot_light0")


def l1_mshrs(number: int) -> list[str]:
    return [f"machine.components.{cache}.mshrs={number}" for cache in ("cpu_l1", "fragment_l1")]


VARIANTS = {
    "as configured": [],
    "1 MSHR in each L1": l1_mshrs(1),
    "2 MSHRs in each L1": l1_mshrs(2),
    "3 MSHRs in each L1": l1_mshrs(3),
    "8 MSHRs in each L1": l1_mshrs(8),
    "8 MSHRs in the L2": ["machine.components.l2.mshrs=8"],
    "FCFS instead of FR-FCFS": ["machine.components.dram.scheduler=fcfs"],
    "channels above lines": ["machine.components.dram.address_map=row:bank:channel:line:offset"],
    "no refresh": ["machine.components.dram.timing.n_refi=0"],
    "a fragment every 4 cycles": ["machine.components.rasterizer.interval_cycles=4"],
}


def recorded(row: str) -> dict[str, list[Tasks]]:
    """The work of both phases of a row whose samples fit one light view."""
    config = load_run(resources.experiment("johnson2004") / f"{row}.yaml")
    scene, method = load_scene(config.scene), method_of(config.workload)
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    (plan,) = plan_faces(scene, seen, scene.lights[config.workload.light], method)
    memory = izb_memory.lay_out(method.grid, plan.tiles)
    core = phase_machine(config.machine, "izb_build").spec.core
    order = tile_order(plan.tiles, core.num_cores * core.num_threads, config.workload.tile_order == "block")
    build = list(build_work(memory, method.grid, plan.tiles, plan.transform, order).chunks)
    cells = grid_fragments(plan, izb_memory.stencil(memory, method.grid), method.grid)
    raster = list(
        raster_work(memory, method.grid, plan.occluders, cells, lambda samples, depths: None).chunks
    )
    return {"izb_build": build, "izb_raster": raster}


def main() -> None:
    print("| row | machine | build useful % | L2 miss | raster useful % | L2 miss |")
    print("|---|---|---|---|---|---|")
    for row in sys.argv[1:] or ROWS:
        work = recorded(row)
        for name, overrides in VARIANTS.items():
            config = load_run(resources.experiment("johnson2004") / f"{row}.yaml", overrides)
            columns = []
            for role, chunks in work.items():
                machine = phase_machine(config.machine, role)
                num_tasks = sum(tasks.num_tasks for tasks in chunks)
                counters = play("compiled", machine.spec, Work(num_tasks, iter(chunks)))
                slots = counters.cycles * machine.spec.core.num_cores
                miss = counters.cache_fetch_ticks[-1] / counters.cache_fetches[-1]
                columns += [f"{100 * counters.useful.sum() / slots:.2f}"]
                columns += [f"{miss / machine.spec.core.period_ticks:.1f}"]
            print(f"| {row} | {name} | " + " | ".join(columns) + " |", flush=True)


if __name__ == "__main__":
    main()
