"""The record: what flows from the functional layer to the timing layer.

A task is a run of records. A record says: issue `compute` one-cycle instructions, then do one operation that can wait
(or end the task). Timing so costs per operation, not per instruction.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np


class Op(IntEnum):
    """The operation that closes a record. All but END take one issue slot."""

    END = 0  # the task is over; takes no issue slot
    LOAD = 1  # wait until `bytes` at `address` are here
    STORE = 2  # wait until the line of `address` takes the bytes
    LOCK = 3  # wait for lock number `address`
    UNLOCK = 4  # release lock number `address`
    EMIT = 5  # hand one item to the output


RECORD = np.dtype(
    [
        ("address", np.int64),  # byte address, or lock number for LOCK and UNLOCK
        ("compute", np.int32),  # one-cycle instructions before the operation
        ("bytes", np.int16),  # bytes accessed by LOAD and STORE, else 0
        ("op", np.int16),  # Op
    ]
)


class Tasks(NamedTuple):
    """Consecutive tasks: task i is records[starts[i]:starts[i + 1]], its last record's op is END."""

    starts: np.ndarray  # int64 [num_tasks + 1]
    records: np.ndarray  # RECORD [num_records]

    @property
    def num_tasks(self) -> int:
        return len(self.starts) - 1


def num_instructions(tasks: Tasks) -> int:
    """Issue slots that the tasks take: one-cycle instructions and operations other than END."""
    operations = int(np.count_nonzero(tasks.records["op"] != Op.END))
    return int(tasks.records["compute"].sum(dtype=np.int64)) + operations
