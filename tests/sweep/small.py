"""A sweep of a few tiny runs, and workers that do their jobs at once, in this process."""

from collections.abc import Callable

from archsim.sweep.job import Done, RenderJob, perform
from archsim.sweep.spec import SweepConfig

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


class InlineWorkers:
    """Does each job when it is handed over."""

    def __init__(self, capacity: int = 2, do: Callable = perform):
        self.capacity, self.closed = capacity, False
        self.jobs: list = []
        self._do, self._ended = do, []

    def hand(self, token, job):
        self.jobs.append(job)
        self._ended.append((token, self._do(job)))

    def take(self, seconds):
        ended, self._ended = self._ended, []
        return ended

    def close(self):
        self.closed = True

    @property
    def num_rendered(self) -> int:
        return sum(isinstance(job, RenderJob) for job in self.jobs)


class SilentWatch:
    """Counts what it is told."""

    def __init__(self):
        self.points = self.found = 0
        self.errors: list[str] = []

    def begin(self, points, finished):
        self.points, self.found = points, finished

    def started(self, token, what):
        pass

    def rendered(self, token, done):
        pass

    def ended(self, token, what, done: Done):
        if done.error:
            self.errors.append(done.error)

    def look(self):
        pass
