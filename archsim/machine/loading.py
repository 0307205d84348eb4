"""Tasks of a bounded stream, as far as they are needed: checked when they come, dropped when no thread wants them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from archsim.errors import ArchsimError, fail
from archsim.machine.spec import MachineSpec
from archsim.trace.records import RECORD, Op, Tasks


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
    _check(spec, chunk)

    kept = loaded.starts[first_needed - loaded.first_task :]
    num_kept = int(loaded.starts[-1] - kept[0])
    records = np.require(chunk.records[chunk.starts[0] : chunk.starts[-1]], RECORD, ["C", "A", "W"])
    if num_kept > 0:
        records = np.concatenate([loaded.records[kept[0] : loaded.starts[-1]], records])
    starts = np.concatenate([kept[:-1] - kept[0], chunk.starts - chunk.starts[0] + num_kept])
    return Loaded(first_needed, loaded.num_tasks, starts.astype(np.int64), records)


def _check(spec: MachineSpec, chunk: Tasks) -> None:
    """ArchsimError if a record cannot be played on the machine."""
    records = chunk.records
    if np.any(records["op"][chunk.starts[1:] - 1] != Op.END):
        raise fail("a task does not close with END")

    locks = np.flatnonzero((records["op"] == Op.LOCK) | (records["op"] == Op.UNLOCK))
    numbers = records["address"][locks]
    wrong = np.flatnonzero((numbers < 0) | (numbers >= spec.locks.num_locks))
    if len(wrong) > 0:
        raise _at(locks[wrong[0]], f"lock {numbers[wrong[0]]} of {spec.locks.num_locks} locks")

    accesses = np.flatnonzero((records["op"] == Op.LOAD) | (records["op"] == Op.STORE))
    first = records["address"][accesses]
    last = first + np.maximum(records["bytes"][accesses], 1) - 1
    line_bytes = min((spec.caches[cache].line_bytes for cache in spec.core_cache), default=1)
    wrong = np.flatnonzero((first < 0) | (first // line_bytes != last // line_bytes))
    if len(wrong) > 0:
        what = f"the access to addresses {first[wrong[0]]} to {last[wrong[0]]} crosses a line of {line_bytes} bytes"
        raise _at(accesses[wrong[0]], what)


def _at(record: int, what: str) -> ArchsimError:
    """An error in a record of the chunk."""
    return fail(f"record {record} of the chunk: {what}")
