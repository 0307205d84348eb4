"""Tasks of a bounded stream, as far as they are needed: checked when they come, dropped when no thread wants them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.machine.checking import check_tasks
from archsim.machine.spec import MachineSpec
from archsim.trace.records import RECORD, Tasks, joined


class Loaded(NamedTuple):
    """The tasks first_task, first_task + 1, ... that are at hand."""

    first_task: int
    num_tasks: int  # of the whole work
    starts: np.ndarray  # [loaded + 1] where task first_task + i begins among the records
    records: np.ndarray  # RECORD [num_records]


def nothing_loaded(num_tasks: int) -> Loaded:
    """The beginning of a stream of `num_tasks` tasks."""
    return Loaded(0, num_tasks, np.zeros(1, np.int64), np.zeros(0, RECORD))


def load_next(spec: MachineSpec, loaded: Loaded, chunks: Iterator[Tasks], first_needed: int) -> Loaded:
    """Append the next chunk and drop the tasks before `first_needed`. ArchsimError if the chunk cannot be played."""
    end = loaded.first_task + len(loaded.starts) - 1
    chunk = next(chunks, None)
    if chunk is None:
        raise fail(f"the work ended after {end} of its {loaded.num_tasks} tasks")
    if end + chunk.num_tasks > loaded.num_tasks:
        raise fail(f"the work holds {end + chunk.num_tasks} tasks or more, but announced {loaded.num_tasks}")

    records = np.require(chunk.records[chunk.starts[0] : chunk.starts[-1]], RECORD, ["C", "A", "W"])
    chunk_starts = (chunk.starts - chunk.starts[0]).astype(np.int64)
    check_tasks(spec, chunk_starts, records)
    kept = loaded.starts[first_needed - loaded.first_task :]
    num_kept = int(loaded.starts[-1] - kept[0])
    if num_kept > 0:
        records = joined([loaded.records[kept[0] : loaded.starts[-1]], records])
    starts = np.concatenate([kept[:-1] - kept[0], chunk_starts + num_kept])
    return Loaded(first_needed, loaded.num_tasks, starts, records)
