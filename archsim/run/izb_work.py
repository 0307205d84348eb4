"""The work of an irregular shadow map by itself, to be played on many machines."""

from __future__ import annotations

from typing import Any, NamedTuple

from archsim.errors import ArchsimError, Problem, fail
from archsim.execute import izb_memory
from archsim.execute.izb_build import build_work, tile_order
from archsim.execute.izb_memory import IzbMemory
from archsim.execute.izb_raster import raster_work
from archsim.isa.program import NUM_LOCKS
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.spec import MachineSpec
from archsim.raster.eye_view import eye_view
from archsim.run.izb_statistics import BUILD
from archsim.scene.scene import load_scene
from archsim.shadow.grid import Grid
from archsim.shadow.plain import FacePlan, Method, grid_fragments, plan_faces
from archsim.trace.records import Tasks
from archsim.trace.stream import Work


class Recorded(NamedTuple):
    """Both phases of one light view. All of it is in memory: 16 bytes a record."""

    build: list[Tasks]
    raster: list[Tasks]
    block_threads: (
        int | None
    )  # build threads that `tile_order: block` dealt the tiles to, None if interleaved


def method_of(workload: Any) -> Method:
    """The algorithm's choices in a checked workload section."""
    sizes = (*workload.logical_grid, *workload.physical_grid, *workload.grid_tile)
    return Method(Grid(*sizes), tuple(workload.pixel_tile), workload.depth_offset_cells)


def record(config: Any) -> list[Recorded]:
    """Execute the kernels of a checked RunConfig, once for each light view; no machine is played."""
    scene, method = load_scene(config.scene), method_of(config.workload)
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    plans = plan_faces(scene, seen, scene.lights[config.workload.light], method)
    core = phase_machine(config.machine, BUILD).spec.core
    num_threads = core.num_cores * core.num_threads
    return [_record(plan, method.grid, num_threads, config.workload.tile_order == "block") for plan in plans]


def _record(plan: FacePlan, grid: Grid, num_threads: int, block: bool) -> Recorded:
    memory = izb_memory.lay_out(grid, plan.tiles)
    order = tile_order(plan.tiles, num_threads, block)
    build = list(build_work(memory, grid, plan.tiles, plan.transform, order).chunks)
    cells = grid_fragments(plan, izb_memory.stencil(memory, grid), grid)
    raster = raster_work(memory, grid, plan.occluders, cells, lambda samples, depths: None)
    return Recorded(build, list(raster.chunks), num_threads if block else None)


def replay(work: Recorded, phase: str, spec: MachineSpec) -> Work:
    """A phase of recorded work, to be played once more, on a machine. ArchsimError if it was dealt to another."""
    num_threads = spec.core.num_cores * spec.core.num_threads
    if phase == BUILD and work.block_threads not in (None, num_threads):
        raise fail(
            f"tiles were dealt in blocks to {work.block_threads} threads, the machine has {num_threads}"
        )
    chunks = work.build if phase == BUILD else work.raster
    return Work(sum(tasks.num_tasks for tasks in chunks), iter(chunks))


def check_machine(build: PhaseMachine, memory: IzbMemory) -> None:
    """Raise ArchsimError if the kernels cannot run on the machine: too few locks, too little memory."""
    problems = []
    if build.spec.locks.num_locks < NUM_LOCKS:
        what = (
            f"the kernels use {NUM_LOCKS} locks, the machine's `locks` has count {build.spec.locks.num_locks}"
        )
        problems.append(Problem(None, what))
    needed = memory.windows[1].base + memory.windows[1].size
    if needed > build.dram_bytes:
        what = f"the arrays of this run end at {needed} bytes, the machine's `dram` holds {build.dram_bytes}"
        problems.append(Problem(None, what, "raise its rows, row_bytes, banks or channels"))
    if problems:
        raise ArchsimError(problems)
