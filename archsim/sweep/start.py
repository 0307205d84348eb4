"""From a sweep's file to its folder."""

from __future__ import annotations

from pathlib import Path

from archsim.config.sweep import SweepConfig
from archsim.sweep.conduct import Tally, conduct
from archsim.sweep.plan import Point
from archsim.sweep.store import Index, IndexEntry, only_one, write_index
from archsim.sweep.watch import Watch
from archsim.sweep.workers import Workers


def run_sweep(
    config: SweepConfig,
    points: tuple[list[Point], list[Point]],
    folder: Path,
    how: tuple[Workers, str, Watch],
) -> Tally:
    """Do what is not done yet: `points` are all of the sweep's and this process's share, `how` names the share."""
    plan, mine = points
    workers, part, watch = how
    try:
        with only_one(folder, part):
            write_index(folder, _index(config, plan))
            return conduct(mine, folder.resolve(), workers, part, watch)
    finally:
        workers.close()


def _index(config: SweepConfig, plan: list[Point]) -> Index:
    entries = [IndexEntry(point.parameters, point.command, point.digest) for point in plan]
    return Index(config.name, config.metrics, entries)
