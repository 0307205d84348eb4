"""The work of an irregular shadow map by itself, to be played on many machines."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.config import GridConfig, MachineConfig, RunConfig
from archsim.config.workload import WorkloadConfig
from archsim.errors import ArchsimError, Problem, fail
from archsim.execute import izb_memory
from archsim.execute.izb_build import build_work, tile_order
from archsim.execute.izb_clear import clear_work
from archsim.execute.izb_memory import IzbMemory, Storage, Structure
from archsim.execute.izb_raster import Output, raster_work
from archsim.isa.program import NUM_LOCKS
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.spec import MachineSpec
from archsim.run.izb_statistics import BUILD, CLEAR, RASTER
from archsim.run.izb_subject import Subject, grid_of, subject_of
from archsim.shadow.grid import Grid
from archsim.shadow.plain import FacePlan, grid_fragments
from archsim.trace.records import Tasks
from archsim.trace.stream import Work


class Dealt(NamedTuple):
    """What the work takes from the machine where tiles or nodes are dealt to its threads."""

    build_threads: int


class LightViewWork(NamedTuple):
    """One light view, ready for its kernels to be executed: the build phase first, then the raster phase."""

    plan: FacePlan
    grid: Grid
    tiles: np.ndarray  # pixel tiles in the order in which the build threads take them
    memory: IzbMemory  # changed by the build phase, read by the raster phase
    for_threads: (
        int | None
    )  # build threads that tiles are dealt to in blocks, or nodes from a pool; None: any

    def clear(self) -> Work:
        """What comes before the build phase."""
        return clear_work(self.memory, self.grid)

    def build(self) -> Work:
        """The build phase. The lists are in memory when it has been drawn to its end."""
        return build_work(self.memory, self.grid, self.plan.tiles, self.plan.transform, self.tiles)

    def raster(self, output: Output = lambda samples, depths: None) -> Work:
        """The raster phase, after the build phase; framebuffer fragments go to `output`."""
        cells = grid_fragments(self.plan, izb_memory.stencil(self.memory, self.grid), self.grid)
        return raster_work(self.memory, self.grid, self.plan.occluders, cells, output)

    def recorded(self, output: Output = lambda samples, depths: None) -> Recorded:
        """Both phases, executed and kept."""
        cleared, build = list(self.clear().chunks), list(self.build().chunks)
        raster = list(self.raster(output).chunks)
        return Recorded(cleared, build, raster, self.for_threads, self.needed_bytes)

    @property
    def needed_bytes(self) -> int:
        """Memory that the phases' arrays take, from address 0."""
        window = self.memory.windows[1]
        return window.base + window.size


class Recorded(NamedTuple):
    """The phases of one light view. All of it is in memory: 16 bytes a record."""

    clear: list[Tasks]
    build: list[Tasks]
    raster: list[Tasks]
    for_threads: int | None  # as in LightViewWork
    needed_bytes: int


def takes(config: RunConfig) -> Dealt | None:
    """The number of build threads of the run's machine, if tiles or nodes are dealt to them."""
    assert isinstance(config.workload, GridConfig)
    if config.workload.tile_order != "block" and config.workload.node_layout != "pool":
        return None
    core = phase_machine(config.machine, BUILD).spec.core
    return Dealt(core.num_cores * core.num_threads)


def prepare(workload: WorkloadConfig, dealt: Dealt | None, subject: Subject) -> list[LightViewWork]:
    """The light views of a run; `dealt`: what its work takes from its machine."""
    assert isinstance(workload, GridConfig)
    grid, block = grid_of(workload), workload.tile_order == "block"
    num_threads = dealt.build_threads if dealt else 1  # to deal to one thread is to deal to none
    storage = _storage(workload, num_threads)
    orders = [tile_order(plan.tiles, num_threads, block) for plan in subject.plans]
    return [
        LightViewWork(
            plan,
            grid,
            order,
            izb_memory.lay_out(grid, plan.tiles, order, storage),
            dealt.build_threads if dealt else None,
        )
        for plan, order in zip(subject.plans, orders, strict=True)
    ]


def _storage(workload: GridConfig, num_threads: int) -> Storage:
    """How the workload section wants samples to be stored."""
    pool = num_threads if workload.node_layout == "pool" else 0
    by_tiles = workload.pixel_layout == "tiles"
    structure = Structure[workload.structure.upper()]
    return Storage(structure, workload.locks, pool, by_tiles, workload.head_bytes)


def record(config: RunConfig) -> list[Recorded]:
    """Execute the kernels of a run, once for each light view; no machine is played."""
    return [view.recorded() for view in prepare(config.workload, takes(config), subject_of(config))]


def replay(work: Recorded, phase: str, spec: MachineSpec) -> Work:
    """A phase of recorded work, to be played once more, on a machine. ArchsimError if it was dealt to another."""
    num_threads = spec.core.num_cores * spec.core.num_threads
    if phase == BUILD and work.for_threads not in (None, num_threads):
        raise fail(f"tiles or nodes were dealt to {work.for_threads} threads, the machine has {num_threads}")
    chunks = {CLEAR: work.clear, BUILD: work.build, RASTER: work.raster}[phase]
    return Work(sum(tasks.num_tasks for tasks in chunks), iter(chunks))


def check_machine(machine: MachineConfig, build: PhaseMachine, needed_bytes: int) -> None:
    """Raise ArchsimError if the kernels cannot run on the machine: too few locks, too little memory."""
    problems = []
    if build.spec.locks.num_locks < NUM_LOCKS:
        what = (
            f"the kernels use {NUM_LOCKS} locks, the machine's `locks` has count {build.spec.locks.num_locks}"
        )
        problems.append(Problem(None, what, key=machine.key_of("locks") + ".count"))
    if needed_bytes > build.dram_bytes:
        what = (
            f"the arrays of this run end at {needed_bytes} bytes, "
            f"the machine's `dram` holds {build.dram_bytes}"
        )
        hint = "raise its rows, row_bytes, banks or channels"
        problems.append(Problem(None, what, hint, machine.key_of("dram", "ideal_dram") + ".rows"))
    if problems:
        raise ArchsimError(problems)
