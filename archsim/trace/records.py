"""The record: what flows from the functional layer to the timing layer.

A task is a run of records. A record says: do `compute` steps, then one operation that can wait (or end the task).
A step is a one-cycle instruction of a thread, or whatever a fixed-function unit does `lanes` of a cycle. Timing so
costs per operation, not per instruction.
"""

from __future__ import annotations

from collections.abc import Sequence
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
    EMIT = 5  # hand one item to the output; of a unit: to output number `address`
    TAKE = 6  # of a unit: take one item from input number `address`
    MARK = 7  # of a unit: release what was emitted to output number `address`, a delay stream
    ACQUIRE = 8  # of a unit: wait for a token of pool number `address`
    RELEASE = 9  # of a unit: give a token back to pool number `address`
    CLEAR = 10  # the `bytes` from `address` on are cleared: the cache sets its clear bits for them


RECORD = np.dtype(
    [
        ("address", np.int64),  # byte address, or the number of a lock, input, output or pool
        ("compute", np.int32),  # steps before the operation
        (
            "bytes",
            np.int16,
        ),  # bytes accessed by LOAD and STORE, or cleared, or emitted to a delay stream, else 0
        ("op", np.int16),  # Op
    ]
)


def joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    """RECORD [n]: the records of all parts, one part after the other; each is contiguous.

    They are copied as integers: ten times as fast as field by field, which is how NumPy copies records.
    """
    return np.concatenate([np.zeros(0, np.int64), *(part.view(np.int64) for part in parts)]).view(RECORD)


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
