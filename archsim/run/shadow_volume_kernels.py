"""Both stages of hierarchical shadow volumes as programs on cores, beside the pipeline that has units for them."""

from __future__ import annotations

from typing import NamedTuple

from archsim.config import MachineConfig, RunConfig, VolumeKernelsConfig
from archsim.errors import fail
from archsim.execute.hsv_memory import tile_states
from archsim.execute.hsv_stages import (
    NOTHING,
    Stages,
    classify_work,
    clear_work,
    prepare_stages,
    update_work,
)
from archsim.isa.program import NUM_LOCKS
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.counters import Counters, added, no_counters
from archsim.machine.pipeline.build import pipeline_machine
from archsim.run.counted import play_counted
from archsim.run.listen import Listen
from archsim.run.measure import Measure, measured, ratio
from archsim.run.metrics import equal, phase_checks, phase_latencies, phase_statistics
from archsim.run.progress import Progress
from archsim.run.rendering import Functional, Kind, Piece, Play
from archsim.run.result import Check, Result, Statistic
from archsim.run.shadow_volume_units import (
    Differences,
    differences_of_stage_1,
    differences_of_stage_2,
    new_units,
    together,
)
from archsim.run.shadow_volumes import (
    PHASE,
    Facts,
    OnPipeline,
    Playing,
    equal_masks,
    facts_of,
    method_of,
    pipeline_piece,
    prepare_light,
    resources_of,
)
from archsim.scene.scene import digest, load_scene
from archsim.shadow_volumes.comparison import BRUTE_FORCE, draw, is_bounded
from archsim.shadow_volumes.hierarchical import mask
from archsim.trace.stream import Work

ROLE = "hsv_stages"
CLEAR, STAGE_1, STAGE_2 = PHASES = ("hsv_clear", "hsv_stage1", "hsv_stage2")
FIRST = (
    "workload.triangles",
    "workload.volumes",
    "programmable.milliseconds",
    "programmable.fixed_function_milliseconds",
    "programmable.slowdown",
)
_ENDLESS = 1 << 62  # bytes: two passes need no delay stream, so nothing overflows


class Programs(NamedTuple):
    """What the kernels did, on whatever cores."""

    pixels: int  # stencil operations of what Stage 2 handed on
    tiles: int  # that it handed on, counted with each triangle
    differences: Differences  # from the fixed-function stages


class KernelFacts(NamedTuple):
    """All that does not depend on the cores, besides the work."""

    picture: Facts
    programs: Programs


class Ran(NamedTuple):
    """All batches, played."""

    counters: dict[str, Counters]  # of each phase
    executed: dict[str, int]  # instructions


class Comparison(NamedTuple):
    """The same picture by programs and by units."""

    cores: PhaseMachine
    ran: Ran
    programs: Programs
    fixed_milliseconds: float

    @property
    def cycles(self) -> int:
        """Core cycles of all phases."""
        return sum(counters.cycles for counters in self.ran.counters.values())

    @property
    def milliseconds(self) -> float:
        return 1e3 * self.cycles * self.cores.spec.core.period_ticks / self.cores.tick_hertz

    @property
    def blocks(self) -> int:
        """Tasks of one stage."""
        return int(self.ran.counters[STAGE_1].tasks.sum())


PROGRAMMABLE = [
    Measure("cycles", "cycles", "Core cycles of clearing and both stages, all batches.", lambda c: c.cycles),
    Measure("milliseconds", "ms", "The same as time.", lambda c: c.milliseconds),
    Measure(
        "blocks",
        "blocks",
        "Blocks of 2 x 2 tiles that triangles meet: tasks of each stage.",
        lambda c: c.blocks,
    ),
    Measure(
        "cycles_per_block",
        "cycles",
        "Core cycles over blocks: clearing and both stages.",
        lambda c: ratio(c.cycles, c.blocks),
    ),
    Measure(
        "tiles_drawn",
        "tiles",
        "Tiles that Stage 2 handed on to be drawn, counted with each triangle.",
        lambda c: c.programs.tiles,
    ),
    Measure(
        "fixed_function_milliseconds",
        "ms",
        "Time of the pipeline for the whole frame, geometry and pixels included.",
        lambda c: c.fixed_milliseconds,
    ),
    Measure(
        "slowdown",
        "ratio",
        "Time of the programs over that of the pipeline.",
        lambda c: ratio(c.milliseconds, c.fixed_milliseconds),
    ),
]


def takes(config: RunConfig) -> None:
    """Picture and work take nothing from the cores: batches and fixed function are the workload's."""


def execute(functional: Functional, play: Play) -> KernelFacts:
    """Run both stages as kernels, batch after batch, then the same volumes in fixed function."""
    workload = functional.workload
    assert isinstance(workload, VolumeKernelsConfig)
    resources = resources_of(workload.fixed_function)._replace(delay_stream_bytes=_ENDLESS)
    scene = load_scene(functional.scene)
    view = prepare_light(scene, workload.light, method_of(workload, resources))
    seen = view.seen._replace(bounds=view.bounds) if is_bounded(workload.variant) else view.seen
    stages = prepare_stages(seen, workload.psv_buffers)
    programs = _run(stages, play)
    shadow = view.shown & mask(seen.screen, stages.stencil, tile_states(stages.memory, seen.screen))
    play(pipeline_piece(view, workload.variant, resources, True))
    expected, drawn = draw(view, BRUTE_FORCE, resources), draw(view, workload.variant, resources)
    picture = facts_of(digest(scene), view, drawn, equal_masks(shadow, expected.shadow))
    return KernelFacts(picture._replace(shadow=shadow), programs)


class KernelsPlayer:
    """Both stages on the cores of a run, and the pipeline beside them."""

    def __init__(self, config: RunConfig, progress: Progress, listen: Listen):
        workload = config.workload
        assert isinstance(workload, VolumeKernelsConfig)
        self.config, self.progress, self.listen = config, progress, listen
        self.fixed_function = workload.fixed_function
        how = Playing(config.model, True, progress, listen)
        self.cores = phase_machine(config.machine, ROLE, config.seed)
        self.pipeline = OnPipeline(workload.fixed_function, how)
        counters = {phase: no_counters(self.cores.spec) for phase in PHASES}
        self.ran = Ran(counters, dict.fromkeys(PHASES, 0))

    def play(self, piece: Piece) -> None:
        """Play a batch of a phase, or all in fixed function."""
        if piece.phase not in PHASES:
            self.pipeline.play(piece)
            return
        assert isinstance(piece.work, Work)
        _check_cores(self.config.machine, self.cores, piece.needed_bytes)
        phase, (number, parts) = piece.phase, piece.part

        def report(done: int, total: int) -> None:
            self.progress(phase, number * total + done, parts * total)

        heard = self.listen(phase, self.cores)
        counters, executed = play_counted(self.cores, piece.work, self.config.model, report, heard)
        self.ran.counters[phase] = added(self.ran.counters[phase], counters)
        self.ran.executed[phase] += executed

    def result(self, facts: KernelFacts) -> Result:
        """Programs and units beside each other."""
        (picture, programs), cores, ran = facts, self.cores, self.ran
        fixed = self.pipeline.played(picture.traffic)
        checks = [picture.mask, *_checks(cores, ran, facts), *fixed.checks]
        statistics, latencies = list(picture.statistics), dict(fixed.latencies)
        for phase in PHASES:
            statistics += phase_statistics(phase, cores, ran.counters[phase])
            latencies |= phase_latencies(phase, cores, ran.counters[phase])
        statistics += fixed.statistics
        milliseconds = _milliseconds(self.fixed_function, fixed.statistics)
        statistics += measured("programmable", PROGRAMMABLE, Comparison(cores, ran, programs, milliseconds))
        values = {statistic.name: statistic.value for statistic in statistics}
        summary = {name: values[name] for name in FIRST}
        return Result(
            self.config.name,
            picture.scene_digest,
            {**summary, "checks_passed": all(check.ok for check in checks)},
            statistics,
            checks,
            picture.shadow,
            [picture.histogram],
            picture.maps,
            latencies,
        )


def _milliseconds(fixed_function: MachineConfig, fixed: list[Statistic]) -> float:
    """Time of the pipeline's frame."""
    cycles = {statistic.name: statistic.value for statistic in fixed}[f"{PHASE}.cycles"]
    machine = pipeline_machine(fixed_function)
    return 1e3 * cycles * machine.spec.period_ticks / machine.tick_hertz


def _check_cores(config: MachineConfig, cores: PhaseMachine, needed: int) -> None:
    """ArchsimError if the kernels cannot run on the cores."""
    if cores.spec.locks.num_locks < NUM_LOCKS:
        found = cores.spec.locks.num_locks
        what = f"the kernels use {NUM_LOCKS} locks, the machine's `locks` has count {found}"
        raise fail(what, key=config.key_of("locks") + ".count")
    if needed > cores.dram_bytes:
        what = f"the buffers of this run end at {needed} bytes, the machine's `dram` at {cores.dram_bytes}"
        raise fail(what, key=config.key_of("dram", "ideal_dram"))


def _run(stages: Stages, play: Play) -> Programs:
    """Batch after batch: clear, Stage 1, Stage 2, each played when the one before is over."""
    drawn, differences = [NOTHING] * len(stages.seen.volumes.z_pass), Differences(0, 0, 0)
    units, batches = new_units(stages.seen, stages.memory.num_buffers), stages.batches()
    for number, batch in enumerate(batches):
        part, needed = (number, len(batches)), stages.memory.num_bytes
        play(Piece(CLEAR, clear_work(stages), needed, part))
        play(Piece(STAGE_1, classify_work(stages, batch), needed, part))
        classified = differences_of_stage_1(units, stages, batch)
        play(Piece(STAGE_2, update_work(stages, batch, drawn), needed, part))
        updated = differences_of_stage_2(units, stages, batch, drawn)
        differences = together(differences, together(classified, updated))
    return Programs(sum(d.pixels for d in drawn), sum(len(d.tiles) for d in drawn), differences)


def _checks(cores: PhaseMachine, ran: Ran, facts: KernelFacts) -> list[Check]:
    """That the kernels do what the units do, that the machine issued what they executed, and each phase's laws."""
    programs, different = facts.programs, facts.programs.differences
    checks = [
        equal("stage 1: PSV entries other than the unit's", different.classified, 0),
        equal("stage 2: volumes drawn other than the unit's", different.drawn, 0),
        equal("stage 2: tile states other than the unit's", different.states, 0),
        equal("stencil pixels = the algorithm's", programs.pixels, facts.picture.traffic.stencil_pixels),
        equal("tiles handed on = emitted", programs.tiles, ran.counters[STAGE_2].emitted.sum()),
    ]
    for phase in PHASES:
        counters = ran.counters[phase]
        checks.append(equal(f"{phase}: instructions issued", ran.executed[phase], counters.useful.sum()))
        checks += phase_checks(phase, cores, counters)
    return checks


KIND = Kind(takes, execute, KernelsPlayer)
