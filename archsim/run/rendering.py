"""The two halves of a run: what is computed, which machines may share, and how one machine plays it.

    execute ──Piece by Piece──> Player.play ... ──Facts──> Player.result     a run on its own
       │
       └──────> folder ──────> Player.play ... ──────> Player.result         rendered once, played on many machines

`execute` is given a `Functional` and nothing else, and what machines share is decided by comparing just that; so work
cannot depend on anything that is not compared.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from archsim.config import RunConfig
from archsim.config.scene import SceneConfig
from archsim.config.workload import WorkloadConfig
from archsim.errors import Location, fail
from archsim.run.listen import Listen, to_nothing
from archsim.run.progress import Progress, silent
from archsim.run.result import Result
from archsim.run.series import over_time
from archsim.trace.kept import read_chunks, write_chunks
from archsim.trace.records import Tasks
from archsim.trace.stream import PipelineWork, Work

_KEPT = "kept.pickle"


class Functional(NamedTuple):
    """All that picture and work depend on."""

    scene: SceneConfig | None
    workload: WorkloadConfig
    seed: int
    taken: Any  # from the machine: a NamedTuple of numbers, each kind's own; None: nothing

    def described(self) -> dict[str, Any]:
        """The same as plain values."""
        scene = self.scene and self.scene.model_dump(mode="json")
        workload = self.workload.model_dump(mode="json")
        return {"scene": scene, "workload": workload, "seed": self.seed, "machine": self.from_machine()}

    def from_machine(self) -> dict[str, Any]:
        """What is taken from the machine, by name."""
        return self.taken._asdict() if self.taken is not None else {}


class Piece(NamedTuple):
    """The next work of a phase; what is computed goes on when it has been drawn to its end."""

    phase: str
    work: Work | PipelineWork
    needed_bytes: int  # that its buffers take in memory, from address 0
    part: tuple[int, int] = (0, 1)  # it is number ... of ... such pieces


Play = Callable[[Piece], None]  # draws the work to its end


class Player(Protocol):
    """A machine on its way through the pieces."""

    def play(self, piece: Piece) -> None:
        """Play the next piece. ArchsimError if the machine has no room for it."""

    def result(self, facts: Any) -> Result:
        """What the run comes to; `facts`: what `execute` returned after the last piece."""


class Kind(NamedTuple):
    """One kind of workload."""

    takes: Callable[[RunConfig], Any]  # what picture and work take from the machine, as in Functional
    execute: Callable[[Functional, Play], Any]  # computes, has each piece played; picklable facts
    player: Callable[[RunConfig, Progress, Listen], Player]

    def functional(self, config: RunConfig) -> Functional:
        """All that the run's picture and work depend on."""
        return Functional(config.scene, config.workload, config.seed, self.takes(config))

    def simulate(self, config: RunConfig, progress: Progress = silent, listen: Listen = to_nothing) -> Result:
        """Compute and play at once."""
        return over_time(config.statistics.interval_cycles, listen, partial(self._simulate, config, progress))

    def render(self, config: RunConfig, folder: Path) -> None:
        """Compute, and keep work and facts in an empty folder, chunk by chunk; no machine is played."""
        pieces: list[Piece] = []

        def keep(piece: Piece) -> None:
            write_chunks(_chunks_of(folder, len(pieces)), _joint(piece.work))
            pieces.append(_with(piece, iter(())))

        functional = self.functional(config)
        facts = self.execute(functional, keep)
        kept = _Kept(functional.described(), pieces, facts)
        (folder / _KEPT).write_bytes(pickle.dumps(kept))

    def replay(
        self, config: RunConfig, folder: Path, progress: Progress = silent, listen: Listen = to_nothing
    ) -> Result:
        """The same result as `simulate`, from what was kept. ArchsimError if that depends on something else."""
        return over_time(
            config.statistics.interval_cycles, listen, partial(self._replay, config, folder, progress)
        )

    def _simulate(self, config: RunConfig, progress: Progress, listen: Listen) -> Result:
        player = self.player(config, progress, listen)
        return player.result(self.execute(self.functional(config), player.play))

    def _replay(self, config: RunConfig, folder: Path, progress: Progress, listen: Listen) -> Result:
        player = self.player(config, progress, listen)
        kept: _Kept = pickle.loads((folder / _KEPT).read_bytes())
        if kept.described != self.functional(config).described():
            raise fail("holds the work of a run whose picture or work differs", Location(str(folder)))
        for number, piece in enumerate(kept.pieces):
            player.play(_read(piece, _chunks_of(folder, number)))
        return player.result(kept.facts)


class _Kept(NamedTuple):
    """What is kept besides the chunks."""

    described: dict[str, Any]
    pieces: list[Piece]  # without chunks
    facts: Any


def _chunks_of(folder: Path, number: int) -> Path:
    return folder / f"{number}.chunks"


def _joint(work: Work | PipelineWork) -> Iterator[tuple[Tasks, ...]]:
    """Chunks as those of a pipeline; cores are one unit."""
    if isinstance(work, PipelineWork):
        return work.chunks
    return ((tasks,) for tasks in work.chunks)


def _read(piece: Piece, path: Path) -> Piece:
    """The piece with its chunks, which are in a file."""
    if isinstance(piece.work, PipelineWork):
        return _with(piece, read_chunks(path, len(piece.work.units)))
    return _with(piece, (tasks for (tasks,) in read_chunks(path, 1)))


def _with(piece: Piece, chunks: Iterator[Any]) -> Piece:
    return piece._replace(work=piece.work._replace(chunks=chunks))
