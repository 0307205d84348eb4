"""How fast this computer simulates: both phases of an irregular shadow map, kernels and timing apart."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from archsim.config import load_run
from archsim.execute import izb_memory
from archsim.execute.izb_build import build_work, tile_order
from archsim.execute.izb_raster import raster_work
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.compiled import simulate
from archsim.raster.eye_view import eye_view
from archsim.run.progress import Progress, silent
from archsim.scene.scene import load_scene
from archsim.shadow.grid import Grid
from archsim.shadow.plain import FacePlan, Method, grid_fragments, plan_faces
from archsim.trace.records import Tasks, num_instructions
from archsim.trace.stream import Work

RUN = "runs/izb_bloodprison_light0.yaml"
OVERRIDES = ("scene.resolution=[640, 512]",)
REPETITIONS = 3  # the fastest counts: other work on the computer only ever slows one down
_MEBIBYTE = 2**20


class Row(NamedTuple):
    """One measurement."""

    name: str
    value: float
    unit: str


class _Workload(NamedTuple):
    """One light view and the machines of both phases."""

    plan: FacePlan
    grid: Grid
    build: PhaseMachine
    raster: PhaseMachine


def measure(overrides: tuple[str, ...] = OVERRIDES, progress: Progress = silent) -> list[Row]:
    """All measurements; the first repetition compiles and is not counted."""
    workload = _workload(overrides)
    best: dict[str, float] = {}
    for repetition in range(REPETITIONS + 1):
        progress("measuring", repetition, REPETITIONS + 1)
        for name, speed in _speeds(workload).items():
            if repetition > 0:
                best[name] = max(best.get(name, 0.0), speed)
    progress("measuring", 1, 1)
    rows = [Row(name, round(speed), "simulated instructions/s") for name, speed in best.items()]
    return [*rows, Row("peak_memory", round(_peak_bytes() / _MEBIBYTE, 1), "MiB")]


def _workload(overrides: tuple[str, ...]) -> _Workload:
    """The light view with the most samples."""
    config = load_run(RUN, overrides)
    scene = load_scene(config.scene)
    sizes = config.workload
    grid = Grid(*sizes.logical_grid, *sizes.physical_grid, *sizes.grid_tile)
    method = Method(grid, sizes.pixel_tile, sizes.depth_offset_cells)
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    plans = plan_faces(scene, seen, scene.lights[sizes.light], method)
    plan = max(plans, key=lambda plan: int(plan.face.taken.sum()))
    return _Workload(
        plan, grid, phase_machine(config.machine, "izb_build"), phase_machine(config.machine, "izb_raster")
    )


def _speeds(workload: _Workload) -> dict[str, float]:
    """Instructions a second of everything, once."""
    plan, grid = workload.plan, workload.grid
    core = workload.build.spec.core
    tiles = tile_order(plan.tiles, core.num_cores * core.num_threads, False)
    memory = izb_memory.lay_out(grid, plan.tiles)
    build = _phase(workload.build, build_work(memory, grid, plan.tiles, plan.transform, tiles))

    cells = grid_fragments(plan, izb_memory.stencil(memory, grid), grid)
    raster = _phase(workload.raster, raster_work(memory, grid, plan.occluders, cells, lambda *_: None))
    phases = {"izb_build": build, "izb_raster": raster}
    return {f"{phase}.{what}": speed for phase, speeds in phases.items() for what, speed in speeds.items()}


def _phase(machine: PhaseMachine, work: Work) -> dict[str, float]:
    """Instructions a second that the interpreter executes and that the timing layer plays."""
    chunks, interpreting = _timed(lambda: list(work.chunks))
    instructions = sum(num_instructions(tasks) for tasks in chunks)
    _, timing = _timed(lambda: simulate(machine.spec, _replay(work.num_tasks, chunks)))
    return {"timing": instructions / timing, "interpret": instructions / interpreting}


def _replay(num_tasks: int, chunks: list[Tasks]) -> Work:
    return Work(num_tasks, iter(chunks))


def _timed(action: Callable[[], Any]) -> tuple[Any, float]:
    """What the action returns, and the seconds it took."""
    started = time.perf_counter()
    result = action()
    return result, time.perf_counter() - started


def _peak_bytes() -> int:
    """The largest resident memory of this process so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
