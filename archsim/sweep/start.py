"""From a sweep's file to its folder."""

from __future__ import annotations

from pathlib import Path

from archsim.config import LoadedSweep, load_run_with_origins
from archsim.config.explain import origins
from archsim.sweep.conduct import Tally, conduct
from archsim.sweep.origins import parameter_origins
from archsim.sweep.plan import Point
from archsim.sweep.store import Index, IndexEntry, only_one, write_index
from archsim.sweep.watch import Watch
from archsim.sweep.workers import Workers


def run_sweep(
    sweep: LoadedSweep,
    run: str,
    points: tuple[list[Point], list[Point]],
    folder: Path,
    how: tuple[Workers, str, Watch],
) -> Tally:
    """Do what is not done yet of a sweep that starts from the file `run`.

    `points` are all of the sweep's and this process's share, `how` names the share.
    """
    plan, mine = points
    workers, part, watch = how
    try:
        with only_one(folder, part):
            write_index(folder, _index(sweep, run, plan))
            return conduct(mine, folder.resolve(), workers, part, watch)
    finally:
        workers.close()


def _index(sweep: LoadedSweep, run: str, plan: list[Point]) -> Index:
    entries = [IndexEntry(point.parameters, point.command, point.digest) for point in plan]
    set_by_sweep = parameter_origins(sweep, [point.parameters for point in plan])
    return Index(
        sweep.config.name, sweep.config.metrics, entries, set_by_sweep, origins(load_run_with_origins(run))
    )
