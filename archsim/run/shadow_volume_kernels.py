"""Both stages of hierarchical shadow volumes as programs on cores, beside the pipeline that has units for them."""

from __future__ import annotations

from typing import NamedTuple

from archsim.config import MachineConfig, RunConfig, VolumeKernelsConfig
from archsim.errors import fail
from archsim.execute.hsv_memory import tile_states
from archsim.execute.hsv_stages import (
    NOTHING,
    Drawn,
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
from archsim.run.listen import Listen, to_nothing
from archsim.run.measure import Measure, measured, ratio
from archsim.run.metrics import equal, phase_checks, phase_latencies, phase_statistics
from archsim.run.progress import Progress, silent
from archsim.run.result import Check, Result, Statistic
from archsim.run.shadow_volume_statistics import TRAFFIC, WORKLOAD
from archsim.run.shadow_volume_units import (
    Differences,
    differences_of_stage_1,
    differences_of_stage_2,
    new_units,
    together,
)
from archsim.run.shadow_volumes import (
    PHASE,
    Playing,
    equal_masks,
    method_of,
    play_on_pipeline,
    prepare_light,
    resources_of,
    update_histogram,
    update_map,
)
from archsim.scene.scene import digest, load_scene
from archsim.shadow_volumes.comparison import BRUTE_FORCE, Traffic, draw, is_bounded
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


class Told(NamedTuple):
    """By which model the phases are played, and who hears of it."""

    model: str
    progress: Progress
    listen: Listen


class Ran(NamedTuple):
    """All batches, executed and played."""

    counters: dict[str, Counters]  # of each phase
    executed: dict[str, int]  # instructions
    drawn: list[Drawn]  # of each volume
    differences: Differences  # from the fixed-function stages


class Comparison(NamedTuple):
    """The same picture by programs and by units."""

    cores: PhaseMachine
    ran: Ran
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
        lambda c: sum(len(drawn.tiles) for drawn in c.ran.drawn),
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


def simulate_shadow_volume_kernels(
    config: RunConfig, progress: Progress = silent, listen: Listen = to_nothing
) -> Result:
    """Run both stages as kernels, check and compare; `config` is a checked RunConfig of this kind."""
    workload = config.workload
    assert isinstance(workload, VolumeKernelsConfig)
    resources = resources_of(workload.fixed_function)._replace(delay_stream_bytes=_ENDLESS)
    scene = load_scene(config.scene)
    view = prepare_light(scene, workload.light, method_of(workload, resources))
    cores = phase_machine(config.machine, ROLE, config.seed)
    seen = view.seen._replace(bounds=view.bounds) if is_bounded(workload.variant) else view.seen
    stages = prepare_stages(seen, workload.psv_buffers)
    _check_cores(config.machine, cores, stages)

    ran = _run(stages, cores, Told(config.model, progress, listen))
    shadow = view.shown & mask(seen.screen, stages.stencil, tile_states(stages.memory, seen.screen))
    expected, drawn = draw(view, BRUTE_FORCE, resources), draw(view, workload.variant, resources)
    how = Playing(config.model, workload.variant, True, progress, listen)
    fixed = play_on_pipeline(workload.fixed_function, view, drawn.traffic, how)
    checks = [equal_masks(shadow, expected.shadow), *_checks(cores, ran, drawn.traffic), *fixed.checks]
    statistics = [*measured("workload", WORKLOAD, view), *measured("traffic", TRAFFIC, drawn.traffic)]
    latencies = dict(fixed.latencies)
    for phase in PHASES:
        statistics += phase_statistics(phase, cores, ran.counters[phase])
        latencies |= phase_latencies(phase, cores, ran.counters[phase])
    statistics += fixed.statistics
    statistics += measured(
        "programmable", PROGRAMMABLE, Comparison(cores, ran, _milliseconds(workload, fixed.statistics))
    )

    values = {statistic.name: statistic.value for statistic in statistics}
    summary = {name: values[name] for name in FIRST}
    summary["checks_passed"] = all(check.ok for check in checks)
    maps = update_map(drawn, workload.tile)
    histograms = [update_histogram(drawn, workload.tile)]
    return Result(
        config.name, digest(scene), summary, statistics, checks, shadow, histograms, maps, latencies
    )


def _milliseconds(workload: VolumeKernelsConfig, fixed: list[Statistic]) -> float:
    """Time of the pipeline's frame."""
    cycles = {statistic.name: statistic.value for statistic in fixed}[f"{PHASE}.cycles"]
    machine = pipeline_machine(workload.fixed_function)
    return 1e3 * cycles * machine.spec.period_ticks / machine.tick_hertz


def _check_cores(config: MachineConfig, cores: PhaseMachine, stages: Stages) -> None:
    """ArchsimError if the kernels cannot run on the cores."""
    if cores.spec.locks.num_locks < NUM_LOCKS:
        found = cores.spec.locks.num_locks
        what = f"the kernels use {NUM_LOCKS} locks, the machine's `locks` has count {found}"
        raise fail(what, key=config.key_of("locks") + ".count")
    if stages.memory.num_bytes > cores.dram_bytes:
        needed = stages.memory.num_bytes
        what = f"the buffers of this run end at {needed} bytes, the machine's `dram` at {cores.dram_bytes}"
        raise fail(what, key=config.key_of("dram", "ideal_dram"))


def _run(stages: Stages, cores: PhaseMachine, how: Told) -> Ran:
    """Batch after batch: clear, Stage 1, Stage 2, each played when the one before is over."""
    counters = {phase: no_counters(cores.spec) for phase in PHASES}
    drawn = [NOTHING] * len(stages.seen.volumes.z_pass)
    ran = Ran(counters, dict.fromkeys(PHASES, 0), drawn, Differences(0, 0, 0))
    units, batches = new_units(stages.seen, stages.memory.num_buffers), stages.batches()
    for number, batch in enumerate(batches):

        def told(what: str, done: int, total: int, number: int = number) -> None:
            how.progress(what, number * total + done, len(batches) * total)

        _play(ran, CLEAR, clear_work(stages), (cores, how._replace(progress=told)))
        _play(ran, STAGE_1, classify_work(stages, batch), (cores, how._replace(progress=told)))
        classified = differences_of_stage_1(units, stages, batch)
        _play(ran, STAGE_2, update_work(stages, batch, drawn), (cores, how._replace(progress=told)))
        updated = differences_of_stage_2(units, stages, batch, drawn)
        ran = ran._replace(differences=together(ran.differences, together(classified, updated)))
    return ran


def _play(ran: Ran, phase: str, work: Work, how: tuple[PhaseMachine, Told]) -> None:
    """Add one batch of a phase to `ran`."""
    cores, told = how

    def report(done: int, total: int) -> None:
        told.progress(phase, done, total)

    counters, executed = play_counted(cores, work, told.model, report, told.listen(phase, cores))
    ran.counters[phase] = added(ran.counters[phase], counters)
    ran.executed[phase] += executed


def _checks(cores: PhaseMachine, ran: Ran, traffic: Traffic) -> list[Check]:
    """That the kernels do what the units do, that the machine issued what they executed, and each phase's laws."""
    different, handed_on = ran.differences, sum(len(drawn.tiles) for drawn in ran.drawn)
    checks = [
        equal("stage 1: PSV entries other than the unit's", different.classified, 0),
        equal("stage 2: volumes drawn other than the unit's", different.drawn, 0),
        equal("stage 2: tile states other than the unit's", different.states, 0),
        equal("stencil pixels = the algorithm's", sum(d.pixels for d in ran.drawn), traffic.stencil_pixels),
        equal("tiles handed on = emitted", handed_on, ran.counters[STAGE_2].emitted.sum()),
    ]
    for phase in PHASES:
        counters = ran.counters[phase]
        checks.append(equal(f"{phase}: instructions issued", ran.executed[phase], counters.useful.sum()))
        checks += phase_checks(phase, cores, counters)
    return checks
