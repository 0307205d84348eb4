"""Work as a bounded stream: chunks of tasks that the timing layer pulls when it runs dry."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from archsim.trace.records import Tasks


class Work(NamedTuple):
    """Tasks in dispatch order. `num_tasks` is known beforehand; the chunks are produced once, in order."""

    num_tasks: int
    chunks: Iterator[Tasks]


def whole(tasks: Tasks) -> Work:
    """A single chunk that is already there."""
    return Work(tasks.num_tasks, iter([tasks]))


def chunked(num_tasks: int, chunks: Iterable[Tasks]) -> Work:
    """Work that is produced as it is played."""
    return Work(num_tasks, iter(chunks))


class PipelineWork(NamedTuple):
    """Tasks of every unit of a pipeline, in joint chunks that are produced once, in order.

    machine/pipeline/README.md says what a unit's records mean and which tasks belong into one chunk.
    """

    units: tuple[str, ...]  # names of the machine's units
    chunks: Iterator[tuple[Tasks, ...]]  # of each unit, in the order of `units`, its next tasks
