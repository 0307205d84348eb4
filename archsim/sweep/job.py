"""What a worker process does: render one picture, or play one point."""

from __future__ import annotations

import time
import traceback
from pathlib import Path
from typing import NamedTuple

from archsim.config import RunConfig
from archsim.errors import ArchsimError, fail
from archsim.run.folder import publish
from archsim.run.kinds import kind_of
from archsim.sweep.store import write_point


class RenderJob(NamedTuple):
    """Render a picture and keep its work."""

    config: RunConfig
    work: Path


class PointJob(NamedTuple):
    """Play a point, on work that was rendered before if there is any, and keep its result."""

    folder: Path  # of the sweep
    digest: str
    config: RunConfig
    command: str
    work: Path | None


class Done(NamedTuple):
    """How a job ended."""

    seconds: float
    error: str | None = None


def perform(job: RenderJob | PointJob) -> Done:
    """Do it. An error of any kind is what the job comes to, not the end of the worker."""
    started = time.perf_counter()
    try:
        if isinstance(job, RenderJob):
            _render(job)
        else:
            _play(job, started)
    except ArchsimError as error:
        return Done(time.perf_counter() - started, str(error))
    except Exception as error:
        text = "".join(traceback.format_exception(error, limit=-4)).strip()
        return Done(time.perf_counter() - started, text)
    return Done(time.perf_counter() - started)


def _render(job: RenderJob) -> None:
    if job.work.is_dir():  # a cluster may do a job twice
        return
    publish(job.work, True, lambda folder: kind_of(job.config).render(job.config, folder))


def _play(job: PointJob, started: float) -> None:
    kind = kind_of(job.config)
    result = kind.simulate(job.config) if job.work is None else kind.replay(job.config, job.work)
    broken = [f"check failed: {check.name}: {check.detail}" for check in result.checks if not check.ok]
    if broken:
        raise fail("\n".join(broken))
    write_point(job.folder, job.digest, job.config, result, time.perf_counter() - started, job.command)
