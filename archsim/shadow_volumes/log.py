"""What a unit of the pipeline does, written down as records while the algorithm runs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled
from archsim.trace.records import RECORD, Op, Tasks

END, LOAD, STORE, EMIT, TAKE, MARK, ACQUIRE, RELEASE, CLEAR = (
    int(op) for op in (Op.END, Op.LOAD, Op.STORE, Op.EMIT, Op.TAKE, Op.MARK, Op.ACQUIRE, Op.RELEASE, Op.CLEAR)
)
RECORDS, TASKS, STEPS = range(3)


class Log(NamedTuple):
    """Tasks of one unit; the space for them must be there."""

    records: np.ndarray  # RECORD [capacity]
    starts: np.ndarray  # int64 [tasks + 1]
    used: np.ndarray  # int64 [3] records written, tasks ended, steps computed since the last record


def new_log(num_records: int, num_tasks: int) -> Log:
    """Space for so many records and tasks."""
    return Log(np.zeros(num_records, RECORD), np.zeros(num_tasks + 1, np.int64), np.zeros(3, np.int64))


def logged(log: Log) -> Tasks:
    """The tasks written so far, in arrays of their own."""
    num_records, num_tasks, _ = log.used
    return Tasks(log.starts[: num_tasks + 1].copy(), log.records[:num_records].copy())


@compiled
def compute(log, steps):
    """Steps before the next operation."""
    log.used[STEPS] += steps


@compiled
def put(log, op, address, num_bytes):
    """An operation."""
    record = log.records[log.used[RECORDS]]
    record["address"] = address
    record["compute"] = log.used[STEPS]
    record["bytes"] = num_bytes
    record["op"] = op
    log.used[RECORDS] += 1
    log.used[STEPS] = 0


@compiled
def end_task(log):
    """The end of a task."""
    put(log, END, 0, 0)
    log.used[TASKS] += 1
    log.starts[log.used[TASKS]] = log.used[RECORDS]
