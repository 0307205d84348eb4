"""One irregular shadow map on one machine: kernels executed on the scene, their work played, the picture checked."""

from __future__ import annotations

from functools import partial, reduce
from typing import NamedTuple

from archsim.config import RunConfig
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.counters import Counters, added, no_counters
from archsim.run.counted import play_counted
from archsim.run.izb_picture import Emitted, Picture, ViewLaws, compose, find
from archsim.run.izb_statistics import BUILD, CLEAR, RASTER, paper_ratios, summary
from archsim.run.izb_subject import subject_of
from archsim.run.izb_work import check_machine, prepare, takes
from archsim.run.listen import Listen
from archsim.run.metrics import phase_checks, phase_latencies, phase_statistics
from archsim.run.progress import Progress
from archsim.run.rendering import Functional, Kind, Piece, Play
from archsim.run.result import Check, Result
from archsim.trace.stream import Work


class Machines(NamedTuple):
    """The parts of the machine that play the two phases."""

    build: PhaseMachine
    raster: PhaseMachine

    def of(self, phase: str) -> PhaseMachine:
        """What plays a phase; the build's processors clear."""
        return self.raster if phase == RASTER else self.build


class Facts(NamedTuple):
    """All that does not depend on the machine, besides the work."""

    picture: Picture
    laws: list[ViewLaws]


class Played(NamedTuple):
    """One light view's phases, played."""

    clear: Counters
    build: Counters
    raster: Counters
    num_built: int  # instructions that the kernels executed
    num_rastered: int


def execute(functional: Functional, play: Play) -> Facts:
    """Build and rasterize the irregular z-buffer of every light view, phase by phase."""
    subject = subject_of(functional)
    views = prepare(functional.workload, functional.taken, subject)
    found = []
    for view in views:
        emitted = Emitted([], [])
        play(Piece(CLEAR, view.clear(), view.needed_bytes))
        play(Piece(BUILD, view.build(), view.needed_bytes))
        play(Piece(RASTER, view.raster(emitted.take), view.needed_bytes))
        found.append(find(view, emitted))
    return Facts(compose(subject, views, found), [each.laws for each in found])


class IzbPlayer:
    """The phases of every light view on the machine of a run."""

    def __init__(self, config: RunConfig, progress: Progress, listen: Listen):
        self.config, self.progress, self.listen = config, progress, listen
        build, raster = (phase_machine(config.machine, role, config.seed) for role in (BUILD, RASTER))
        self.machines = Machines(build, raster)
        self.played: list[tuple[Counters, int]] = []  # counters and instructions, three phases a view

    def play(self, piece: Piece) -> None:
        """Play a phase of a light view."""
        assert isinstance(piece.work, Work)
        check_machine(self.config.machine, self.machines.build, piece.needed_bytes)
        machine = self.machines.of(piece.phase)
        report, heard = partial(self.progress, piece.phase), self.listen(piece.phase, machine)
        self.played.append(play_counted(machine, piece.work, self.config.model, report, heard))

    def result(self, facts: Facts) -> Result:
        """All light views together."""
        views = zip(*[iter(self.played)] * 3, strict=True)
        played = [
            Played(clear, build, raster, built, rastered)
            for (clear, _), (build, built), (raster, rastered) in views
        ]
        return _result(self.config.name, facts, played, self.machines)


def _result(name: str, facts: Facts, played: list[Played], machines: Machines) -> Result:
    """All light views together as one result."""
    picture = facts.picture
    clear = reduce(added, (face.clear for face in played), no_counters(machines.build.spec))
    build = reduce(added, (face.build for face in played), no_counters(machines.build.spec))
    raster = reduce(added, (face.raster for face in played), no_counters(machines.raster.spec))
    checks = [
        *_view_checks(facts.laws, played),
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


KIND = Kind(takes, execute, IzbPlayer)
