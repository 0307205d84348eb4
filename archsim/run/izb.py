"""One irregular shadow map on one machine: kernels executed on the scene, their work played, the picture checked."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from typing import NamedTuple

import numpy as np

from archsim.config import RunConfig
from archsim.execute import izb_memory
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.counters import Counters, added, no_counters
from archsim.machine.play import play
from archsim.raster.eye_view import EyeView, eye_view
from archsim.run.izb_figures import cell_map, fragment_histogram, fragments_of_samples, list_histogram
from archsim.run.izb_statistics import (
    BUILD,
    RASTER,
    paper_ratios,
    picture_statistics,
    summary,
    workload_statistics,
)
from archsim.run.izb_work import LightViewWork, check_machine, method_of, prepare
from archsim.run.metrics import phase_checks, phase_statistics
from archsim.run.progress import Progress
from archsim.run.result import Check, Result
from archsim.scene.scene import Scene, digest, load_scene
from archsim.shadow import izb
from archsim.shadow.grid import Grid
from archsim.shadow.pixel_tiles import untile
from archsim.shadow.plain import FacePlan, Outcome, run_face
from archsim.shadow.workload import NOTHING, combined
from archsim.trace.records import Tasks, num_instructions
from archsim.trace.stream import Work


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
    outcome: Outcome  # the plain algorithm's
    checks: list[Check]


def simulate_izb(config: RunConfig, progress: Progress) -> Result:
    """Build and rasterize the irregular z-buffer of one light; `config` is a checked RunConfig."""
    scene = load_scene(config.scene)
    machines = Machines(
        phase_machine(config.machine, BUILD), phase_machine(config.machine, RASTER), config.model
    )
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    views = prepare(config, scene, seen)
    faces = [_simulate_face(view, machines, progress) for view in views]
    plans = [view.plan for view in views]
    return _result(config.name, (scene, seen), (plans, faces), method_of(config.workload).grid, machines)


def _simulate_face(view: LightViewWork, machines: Machines, progress: Progress) -> FaceResult:
    """Both phases of one light view, and the same by the plain algorithm."""
    memory, grid = view.memory, view.grid
    check_machine(machines.build, memory)
    expected = run_face(view.plan, grid, _sample_order(view.plan, view.tiles))

    build, built = _played(machines.build, view.build(), (BUILD, machines.model, progress))
    collector = _Collector([], [])
    raster, rastered = _played(
        machines.raster, view.raster(collector.take), (RASTER, machines.model, progress)
    )

    emitted = collector.all()
    tested = izb.z_test_fragments(izb.z_test(expected.samples), *emitted)
    checks = [
        _check(
            "build kernel = plain algorithm", _same_lists(memory, grid, expected), "nodes, lists, stencil"
        ),
        _check("raster kernel = plain algorithm", _same_fragments(emitted, expected), "fragments in order"),
        _check(f"{BUILD}: instructions issued", built == int(build.useful.sum()), built),
        _check(f"{RASTER}: instructions issued", rastered == int(raster.useful.sum()), rastered),
        _check(f"{RASTER}: 5 a fragment, 7 a node, 2 a hit", _explained(expected) == rastered, rastered),
        _check("fragments emitted = played", len(emitted[0]) == int(raster.emitted.sum()), len(emitted[0])),
    ]
    return FaceResult(build, raster, izb.in_shadow(tested, expected.samples), expected, checks)


def _check(name: str, ok: bool, detail: object) -> Check:
    return Check(name, ok, str(detail))


def _explained(expected: Outcome) -> int:
    """Instructions that `izb_raster.s` takes for what the plain algorithm counts."""
    workload = expected.workload
    fragments, hits = workload.grid_fragments_post_stencil, workload.framebuffer_fragments_pre_z
    return 5 * fragments + 7 * workload.node_visits + 2 * hits


def _sample_order(plan: FacePlan, tiles: np.ndarray) -> np.ndarray:
    """Samples in the order in which the build kernel inserts them."""
    per_tile = plan.tiles.num_pairs * 2
    return (tiles[:, None] * per_tile + np.arange(per_tile)).ravel()


def _played(machine: PhaseMachine, work: Work, how: tuple[str, str, Progress]) -> tuple[Counters, int]:
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
        and np.array_equal(emitted[1].view(np.int32), expected.fragments.depth.view(np.int32))
    )


def _result(
    name: str,
    view: tuple[Scene, EyeView],
    simulated: tuple[list[FacePlan], list[FaceResult]],
    grid: Grid,
    machines: Machines,
) -> Result:
    """All light views together as one result."""
    (scene, seen), (_, faces) = view, simulated
    workload = reduce(combined, (face.outcome.workload for face in faces), NOTHING)
    build = reduce(added, (face.build for face in faces), no_counters(machines.build.spec))
    raster = reduce(added, (face.raster for face in faces), no_counters(machines.raster.spec))
    shadow, fragments = _images(scene, *simulated)
    checks = [
        check if len(faces) == 1 else check._replace(name=f"light view {number}: {check.name}")
        for number, face in enumerate(faces)
        for check in face.checks
    ]
    checks += phase_checks(BUILD, machines.build, build) + phase_checks(RASTER, machines.raster, raster)
    statistics = [
        *workload_statistics(workload, len(faces)),
        *picture_statistics(seen, shadow),
        *phase_statistics(BUILD, machines.build, build),
        *phase_statistics(RASTER, machines.raster, raster),
        *paper_ratios(workload, build, raster),
    ]
    outcomes = [face.outcome for face in faces]
    maps = {"Framebuffer fragments of each pixel": fragments}
    if outcomes:
        maps["Samples in each logical cell, first light view"] = cell_map(outcomes[0], grid)
    histograms = [list_histogram(outcomes, grid), fragment_histogram(outcomes)]
    return Result(
        name, digest(scene), summary(statistics, checks), statistics, checks, shadow, histograms, maps
    )


def _images(scene: Scene, plans: list[FacePlan], faces: list[FaceResult]) -> tuple[np.ndarray, np.ndarray]:
    """The shadow mask, and framebuffer fragments of each pixel (NaN where there is no sample)."""
    size = (scene.height, scene.width)
    shadow = np.zeros(size, np.bool_)
    fragments = np.full(size, np.nan, np.float32)
    for plan, face in zip(plans, faces, strict=True):
        shadow |= untile(plan.tiles, face.shadow, *size)
        counts = untile(plan.tiles, fragments_of_samples(face.outcome), *size)
        fragments[plan.face.taken] = counts[plan.face.taken]
    return shadow, fragments
