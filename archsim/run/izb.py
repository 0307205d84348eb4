"""One irregular shadow map on one machine: kernels executed on the scene, their work played, the picture checked."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, reduce
from typing import NamedTuple

from archsim.config import RunConfig
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.counters import Counters, added, no_counters
from archsim.run.counted import play_counted
from archsim.run.izb_picture import Emitted, Picture, ViewLaws, compose, find
from archsim.run.izb_rendered import RenderedIzb
from archsim.run.izb_statistics import BUILD, CLEAR, RASTER, paper_ratios, summary
from archsim.run.izb_subject import subject_of
from archsim.run.izb_work import check_machine, prepare, replay
from archsim.run.listen import Listen, to_nothing
from archsim.run.metrics import phase_checks, phase_latencies, phase_statistics
from archsim.run.progress import Progress
from archsim.run.result import Check, Result
from archsim.trace.stream import Work


class Machines(NamedTuple):
    """The parts of the machine that play the two phases, and the model that plays them."""

    build: PhaseMachine
    raster: PhaseMachine
    model: str
    listen: Listen = to_nothing


class Played(NamedTuple):
    """One light view's phases, played."""

    clear: Counters
    build: Counters
    raster: Counters
    num_built: int  # instructions that the kernels executed
    num_rastered: int


def simulate_izb(config: RunConfig, progress: Progress, listen: Listen = to_nothing) -> Result:
    """Build and rasterize the irregular z-buffer of one light view; `config` is a checked RunConfig."""
    machines, subject = machines_of(config)._replace(listen=listen), subject_of(config)
    views = prepare(config, subject)
    played, found = [], []
    for view in views:
        check_machine(config.machine, machines.build, view.needed_bytes)
        emitted = Emitted([], [])
        played.append(_play((view.clear, view.build, partial(view.raster, emitted.take)), machines, progress))
        found.append(find(view, emitted))
    laws = [each.laws for each in found]
    return _result(config.name, compose(subject, views, found), (laws, played), machines)


def replay_izb(
    config: RunConfig, rendered: RenderedIzb, progress: Progress, listen: Listen = to_nothing
) -> Result:
    """The same result from work that was rendered before, on the machine of `config`."""
    machines = machines_of(config)._replace(listen=listen)
    played = []
    for view in rendered.views:
        check_machine(config.machine, machines.build, view.needed_bytes)
        clear = partial(replay, view, CLEAR, machines.build.spec)
        build = partial(replay, view, BUILD, machines.build.spec)
        raster = partial(replay, view, RASTER, machines.raster.spec)
        played.append(_play((clear, build, raster), machines, progress))
    return _result(config.name, rendered.picture, (rendered.laws, played), machines)


def machines_of(config: RunConfig) -> Machines:
    """What plays the run's two phases."""
    build, raster = (phase_machine(config.machine, role, config.seed) for role in (BUILD, RASTER))
    return Machines(build, raster, config.model)


Phases = tuple[Callable[[], Work], Callable[[], Work], Callable[[], Work]]  # clear, build, raster


def _play(phases: Phases, machines: Machines, progress: Progress) -> Played:
    """The phases of one light view, each made when the one before is over; the build's processors clear."""
    clear, build, raster = phases
    cleared, _ = _phase(machines.build, clear(), (CLEAR, machines, progress))
    built, num_built = _phase(machines.build, build(), (BUILD, machines, progress))
    rastered, num_rastered = _phase(machines.raster, raster(), (RASTER, machines, progress))
    return Played(cleared, built, rastered, num_built, num_rastered)


def _phase(machine: PhaseMachine, work: Work, how: tuple[str, Machines, Progress]) -> tuple[Counters, int]:
    """Counters of a phase, and the number of instructions that the kernel executed for it."""
    phase, machines, progress = how

    def report(done: int, total: int) -> None:
        progress(phase, done, total)

    return play_counted(machine, work, machines.model, report, machines.listen(phase, machine))


def _result(
    name: str, picture: Picture, views: tuple[list[ViewLaws], list[Played]], machines: Machines
) -> Result:
    """All light views together as one result."""
    played = views[1]
    clear = reduce(added, (face.clear for face in played), no_counters(machines.build.spec))
    build = reduce(added, (face.build for face in played), no_counters(machines.build.spec))
    raster = reduce(added, (face.raster for face in played), no_counters(machines.raster.spec))
    checks = [
        *_view_checks(*views),
        *phase_checks(CLEAR, machines.build, clear),
        *phase_checks(BUILD, machines.build, build),
        *phase_checks(RASTER, machines.raster, raster),
    ]
    statistics = [
        *picture.statistics,
        *phase_statistics(CLEAR, machines.build, clear),
        *phase_statistics(BUILD, machines.build, build),
        *phase_statistics(RASTER, machines.raster, raster),
        *paper_ratios(picture.workload, build, raster),
    ]
    return Result(
        name,
        picture.scene_digest,
        summary(statistics, checks),
        statistics,
        checks,
        picture.shadow,
        picture.histograms,
        picture.maps,
        {
            **phase_latencies(CLEAR, machines.build, clear),
            **phase_latencies(BUILD, machines.build, build),
            **phase_latencies(RASTER, machines.raster, raster),
        },
    )


def _view_checks(laws: list[ViewLaws], played: list[Played]) -> list[Check]:
    """The laws of each light view, named by its number where there are several."""
    checks = []
    for number, (law, face) in enumerate(zip(laws, played, strict=True)):
        own = [*law.checks, *_played_checks(law, face)]
        prefix = f"light view {number}: " if len(laws) > 1 else ""
        checks += [check._replace(name=prefix + check.name) for check in own]
    return checks


def _played_checks(law: ViewLaws, face: Played) -> list[Check]:
    """That the machine issued what the kernels executed, no more and no less."""
    issued = [
        (f"{BUILD}: instructions issued", face.num_built, int(face.build.useful.sum())),
        (f"{RASTER}: instructions issued", face.num_rastered, int(face.raster.useful.sum())),
        ("fragments emitted = played", law.num_fragments, int(face.raster.emitted.sum())),
    ]
    if law.raster_instructions is not None:
        explained = (law.raster_instructions, face.num_rastered)
        issued.insert(2, (f"{RASTER}: 5 a fragment, 7 a node, 2 a hit", *explained))
    return [Check(name, left == right, str(left)) for name, left, right in issued]
