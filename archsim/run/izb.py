"""One irregular shadow map on one machine: kernels executed on the scene, their work played, the picture checked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from archsim.execute import izb_memory
from archsim.execute.izb_build import build_work, tile_order
from archsim.execute.izb_raster import raster_work
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.counters import Counters, added, no_counters
from archsim.machine.play import play
from archsim.raster.eye_view import EyeView, eye_view
from archsim.run.metrics import phase_checks, phase_statistics, ratio
from archsim.run.progress import Progress
from archsim.run.result import Check, Histogram, Result, Statistic
from archsim.scene.scene import Scene, load_scene
from archsim.shadow import izb
from archsim.shadow.grid import Grid
from archsim.shadow.pixel_tiles import untile
from archsim.shadow.plain import FacePlan, Method, Outcome, grid_fragments, plan_faces, run_face
from archsim.shadow.workload import NOTHING, IzbWorkload, combined
from archsim.trace.records import Tasks, num_instructions
from archsim.trace.stream import Work

BUILD, RASTER = "izb_build", "izb_raster"


class Machines(NamedTuple):
    """The parts of the machine that play the two phases, and the model that plays them."""

    build: PhaseMachine
    raster: PhaseMachine
    model: str


class FaceResult(NamedTuple):
    """One light view, simulated."""

    build: Counters
    raster: Counters
    shadow: np.ndarray  # bool [num_samples] in tile order
    fragments: np.ndarray  # int32 [num_samples] framebuffer fragments of each sample
    outcome: Outcome  # the plain algorithm's
    checks: list[Check]


def simulate_izb(config: Any, progress: Progress) -> Result:
    """Build and rasterize the irregular z-buffer of one light; `config` is a checked RunConfig."""
    scene = load_scene(config.scene)
    method = _method(config.workload)
    machines = Machines(
        phase_machine(config.machine, BUILD), phase_machine(config.machine, RASTER), config.model
    )
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    plans = plan_faces(scene, seen, scene.lights[config.workload.light], method)
    block = config.workload.tile_order == "block"
    faces = [_simulate_face(plan, method.grid, machines, block, progress) for plan in plans]
    return _result(config.name, (scene, seen), (plans, faces), method, machines)


def _method(workload: Any) -> Method:
    sizes = (*workload.logical_grid, *workload.physical_grid, *workload.grid_tile)
    return Method(Grid(*sizes), tuple(workload.pixel_tile), workload.depth_offset_cells)


def _simulate_face(
    plan: FacePlan, grid: Grid, machines: Machines, block: bool, progress: Progress
) -> FaceResult:
    """Both phases of one light view, and the same by the plain algorithm."""
    core = machines.build.spec.core
    tiles = tile_order(plan.tiles, core.num_cores * core.num_threads, block)
    expected = run_face(plan, grid, _sample_order(plan, tiles))

    memory = izb_memory.lay_out(grid, plan.tiles)
    build, built = _played(
        machines.build, build_work(memory, grid, plan.tiles, plan.transform, tiles), (BUILD, machines.model, progress)
    )
    collector = _Collector([], [])
    cells = grid_fragments(plan, izb_memory.stencil(memory, grid), grid)
    work = raster_work(memory, grid, plan.occluders, cells, collector.take)
    raster, rastered = _played(machines.raster, work, (RASTER, machines.model, progress))

    emitted = collector.all()
    tested = izb.z_test_fragments(izb.z_test(expected.samples), *emitted)
    checks = [
        Check("build kernel = plain algorithm", _same_lists(memory, grid, expected), "nodes, lists, stencil"),
        Check("raster kernel = plain algorithm", _same_fragments(emitted, expected), "samples, depths, order"),
        Check(f"{BUILD}: instructions issued", built == int(build.useful.sum()), f"{built} executed"),
        Check(f"{RASTER}: instructions issued", rastered == int(raster.useful.sum()), f"{rastered} executed"),
        Check("fragments emitted = tested", len(emitted[0]) == int(raster.emitted.sum()), f"{len(emitted[0])}"),
    ]
    fragments = np.bincount(emitted[0], minlength=len(expected.samples.cell)).astype(np.int32)
    return FaceResult(build, raster, izb.in_shadow(tested, expected.samples), fragments, expected, checks)


def _sample_order(plan: FacePlan, tiles: np.ndarray) -> np.ndarray:
    """Samples in the order in which the build kernel inserts them."""
    per_tile = plan.tiles.num_pairs * 2
    return (tiles[:, None] * per_tile + np.arange(per_tile)).ravel()


def _played(
    machine: PhaseMachine, work: Work, how: tuple[str, str, Progress]
) -> tuple[Counters, int]:
    """Counters of a phase, and the number of instructions that the kernel executed for it."""
    phase, model, progress = how
    executed = [0]

    def counted() -> Iterator[Tasks]:
        for tasks in work.chunks:
            executed[0] += num_instructions(tasks)
            yield tasks

    def report(done: int, total: int) -> None:
        progress(phase, done, total)

    counters = play(model, machine.spec, Work(work.num_tasks, counted()), report)
    return counters, executed[0]


class _Collector(NamedTuple):
    """Framebuffer fragments as they come."""

    samples: list[np.ndarray]
    depths: list[np.ndarray]

    def take(self, samples: np.ndarray, depths: np.ndarray) -> None:
        self.samples.append(samples.astype(np.int32))
        self.depths.append(depths)

    def all(self) -> tuple[np.ndarray, np.ndarray]:
        if not self.samples:
            return np.empty(0, np.int32), np.empty(0, np.float32)
        return np.concatenate(self.samples), np.concatenate(self.depths)


def _same_lists(memory: izb_memory.IzbMemory, grid: Grid, expected: Outcome) -> bool:
    """Whether nodes, heads and stencil in memory are what the plain algorithm makes, to the bit."""
    placed = expected.samples.cell[:, 0] >= 0
    num_samples = len(placed)
    nodes = izb_memory.nodes(memory, num_samples)[placed, :3]
    following = izb_memory.following(memory, num_samples)
    return bool(
        np.array_equal(nodes.view(np.int32), expected.samples.position[placed].view(np.int32))
        and np.array_equal(izb_memory.heads(memory, grid), expected.lists.head)
        and np.array_equal(following[placed], expected.lists.following[placed])
        and np.array_equal(izb_memory.stencil(memory, grid), expected.lists.stencil)
    )


def _same_fragments(emitted: tuple[np.ndarray, np.ndarray], expected: Outcome) -> bool:
    """Whether the kernel emitted what the plain algorithm finds, in the same order, to the bit."""
    return bool(
        np.array_equal(emitted[0], expected.fragments.sample)
        and np.array_equal(emitted[1].view(np.int32), expected.fragments.reciprocal_depth.view(np.int32))
    )


def _result(
    name: str,
    view: tuple[Scene, EyeView],
    simulated: tuple[list[FacePlan], list[FaceResult]],
    method: Method,
    machines: Machines,
) -> Result:
    """All light views together as one result."""
    scene, _ = view
    plans, faces = simulated
    workload = NOTHING
    build, raster = no_counters(machines.build.spec), no_counters(machines.raster.spec)
    shadow = np.zeros((scene.height, scene.width), np.bool_)
    per_pixel = np.full((scene.height, scene.width), np.nan, np.float32)
    checks: list[Check] = []
    for plan, face in zip(plans, faces, strict=True):
        workload = combined(workload, face.outcome.workload)
        build, raster = added(build, face.build), added(raster, face.raster)
        shadow |= untile(plan.tiles, face.shadow, scene.height, scene.width)
        fragments = untile(plan.tiles, face.fragments, scene.height, scene.width)
        per_pixel = np.where(plan.face.taken, fragments, per_pixel).astype(np.float32)
        checks += face.checks
    checks += phase_checks(BUILD, machines.build, build) + phase_checks(RASTER, machines.raster, raster)
    statistics = [
        *_workload_statistics(workload, len(faces), shadow),
        *phase_statistics(BUILD, machines.build, build),
        *phase_statistics(RASTER, machines.raster, raster),
        *_paper_ratios(workload, build, raster),
    ]
    maps = {"Framebuffer fragments of each pixel": per_pixel}
    if faces:
        maps["List length over the logical grid, first light view"] = _list_map(faces[0].outcome, method.grid)
    histograms = [_list_histogram(faces, method.grid), _fragment_histogram(faces)]
    return Result(name, _summary(statistics, checks), statistics, checks, shadow, histograms, maps)


def _workload_statistics(workload: IzbWorkload, num_views: int, shadow: np.ndarray) -> list[Statistic]:
    pre, post = "grid fragments", "framebuffer fragments"
    rows = [
        ("samples", workload.samples, "samples", "Pixels that show geometry and are not at the light itself."),
        ("light_views", num_views, "views", "Perspective views that the light needed to hold all samples."),
        ("shadow_percent", 100.0 * float(shadow.mean()), "%", "Pixels in shadow over all pixels."),
        ("depth_complexity", workload.depth_complexity, "triangles", "Triangles covering a sample in the light view."),
        ("list_length", workload.list_length, "samples", "Samples in a list, over the non-empty physical cells."),
        ("non_empty_cells", workload.non_empty_cells, "cells", "Physical cells whose list holds a sample."),
        ("stencil_width", workload.stencil_width, "cells", "Extent of the populated logical cells."),
        ("stencil_height", workload.stencil_height, "cells", "Extent of the populated logical cells."),
        ("grid_fragments_pre_stencil", workload.grid_fragments_pre_stencil, pre, "Cells overlapped by triangles."),
        ("grid_fragments_post_stencil", workload.grid_fragments_post_stencil, pre, "Those on a marked cell."),
        ("framebuffer_fragments_pre_z", workload.framebuffer_fragments_pre_z, post, "Samples inside triangles."),
        ("framebuffer_fragments_post_z", workload.framebuffer_fragments_post_z, post, "Those that pass the z test."),
    ]
    return [Statistic(f"workload.{name}", value, unit, text) for name, value, unit, text in rows]


def _paper_ratios(workload: IzbWorkload, build: Counters, raster: Counters) -> list[Statistic]:
    per_point = ratio(build.cycles, workload.samples)
    per_fragment = ratio(raster.cycles, workload.framebuffer_fragments_pre_z)
    return [
        Statistic(f"{BUILD}.cycles_per_point", per_point, "cycles", "Build cycles over samples."),
        Statistic(
            f"{RASTER}.cycles_per_tri_sample", per_fragment, "cycles", "Raster cycles over framebuffer fragments pre z."
        ),
    ]


def _summary(statistics: list[Statistic], checks: list[Check]) -> dict[str, Any]:
    names = [
        "workload.samples",
        "workload.shadow_percent",
        "workload.light_views",
        f"{BUILD}.cycles",
        f"{BUILD}.cycles_per_point",
        f"{BUILD}.useful_percent",
        f"{RASTER}.cycles",
        f"{RASTER}.cycles_per_tri_sample",
        f"{RASTER}.useful_percent",
    ]
    values = {statistic.name: statistic.value for statistic in statistics}
    return {**{name: values[name] for name in names}, "checks_passed": all(check.ok for check in checks)}


def _list_lengths(outcome: Outcome, grid: Grid) -> np.ndarray:
    """int64 [num_physical_cells] samples in each list."""
    cell = outcome.samples.cell[outcome.samples.cell[:, 0] >= 0]
    i, j = cell[:, 0].astype(np.int64), cell[:, 1].astype(np.int64)
    physical_i = (i + j // grid.physical_width * grid.tile_width) % grid.physical_width
    physical_j = (j + i // grid.physical_height * grid.tile_height) % grid.physical_height
    return np.bincount(physical_j * grid.physical_width + physical_i, minlength=grid.num_physical_cells)


def _list_histogram(faces: list[FaceResult], grid: Grid) -> Histogram:
    lengths = [_list_lengths(face.outcome, grid) for face in faces]
    counts = np.bincount(np.concatenate(lengths)) if lengths else np.zeros(1, np.int64)
    return Histogram("Length of the physical cells' lists", "samples", counts)


def _fragment_histogram(faces: list[FaceResult]) -> Histogram:
    fragments = [face.fragments[face.outcome.samples.cell[:, 0] >= 0] for face in faces]
    counts = np.bincount(np.concatenate(fragments)) if fragments else np.zeros(1, np.int64)
    return Histogram("Triangles that cover a sample, seen from the light", "triangles", counts)


def _list_map(outcome: Outcome, grid: Grid) -> np.ndarray:
    """float32 [logical rows, logical columns] samples in each logical cell, NaN where there are none."""
    cell = outcome.samples.cell[outcome.samples.cell[:, 0] >= 0]
    flat = np.bincount(cell[:, 1] * grid.logical_width + cell[:, 0], minlength=grid.num_logical_cells)
    image = flat.reshape(grid.logical_height, grid.logical_width).astype(np.float32)
    return np.where(image > 0, image, np.float32(np.nan))
