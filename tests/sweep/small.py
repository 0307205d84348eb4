"""A sweep of a few tiny runs, and workers that do their jobs at once, in this process."""

from collections.abc import Callable

from archsim.config import LoadedSweep, sweep_of
from archsim.config.sweep import SweepConfig
from archsim.sweep.job import RenderJob, perform
from archsim.sweep.workers import OwnProcess

SWEEP = {
    "name": "small",
    "run": "runs/tiny.yaml",
    "set": {"scene.resolution": [16, 12]},
    "parameters": [
        {"grid": {"machine.components.l2.size": ["1 KiB", "2 KiB"]}},
        {"zip": {"workload.depth_offset_cells": [0.015625, 0.03125], "seed": [1, 2]}},
    ],
}


def sweep(**changes) -> SweepConfig:
    return SweepConfig.model_validate({**SWEEP, **changes})


def loaded_sweep(**changes) -> LoadedSweep:
    return sweep_of({**SWEEP, **changes})


class InlineWorkers(OwnProcess):
    """Does each job when it is handed over, and remembers it."""

    def __init__(self, capacity: int = 2, do: Callable = perform):
        super().__init__(do)
        self.capacity, self.closed = capacity, False
        self.jobs: list = []

    def hand(self, token, job):
        self.jobs.append(job)
        super().hand(token, job)

    def close(self):
        self.closed = True

    @property
    def num_rendered(self) -> int:
        return sum(isinstance(job, RenderJob) for job in self.jobs)
