"""From accesses to work: what threads or units play when a trace is replayed with time.

Accesses that cross lines become one operation for each line. A requester makes its accesses in order: as threads, each
when the one before has been answered; as units, each at its cycle, whatever became of the ones before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from archsim.errors import fail
from archsim.trace.accesses import Accesses, Kind
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import Work

_MOST_BYTES = np.iinfo(
    np.int16
).max  # that a record can say; more in one line makes no difference to its time

_LONGEST_PAUSE = np.iinfo(np.int32).max  # cycles that a record can say

Reopen = Callable[[], Accesses]  # the trace from its beginning, always in the same chunks


def split(accesses: np.ndarray, line_bytes: int) -> np.ndarray:
    """The accesses in pieces, in order, each within one line."""
    first = accesses["address"] // line_bytes
    last = (accesses["address"] + (accesses["bytes"] - 1)) // line_bytes
    counts = last - first + 1
    if not np.any(counts > 1):
        return accesses

    pieces = np.repeat(accesses, counts)
    number = np.arange(len(pieces)) - np.repeat(np.cumsum(counts) - counts, counts)  # within its access
    ends = pieces["address"] + pieces["bytes"]
    line = np.repeat(first, counts) + number
    pieces["address"] = np.maximum(pieces["address"], line * line_bytes)
    pieces["bytes"] = np.minimum(ends, (line + 1) * line_bytes) - pieces["address"]
    return pieces


def dealt_work(reopen: Reopen, line_bytes: int) -> Work:
    """A task for each piece: whoever is free makes the next access."""
    num_pieces = sum(len(split(chunk, line_bytes)) for chunk in reopen())
    chunks = (_tasks(split(chunk, line_bytes), None) for chunk in reopen())
    return Work(num_pieces, chunks)


def requesters_work(reopen: Reopen, line_bytes: int, num_requesters: int) -> Work:
    """For TaskOrder.INTERLEAVED: of each chunk, a task for each requester."""
    num_chunks = sum(1 for _ in reopen())
    chunks = (_tasks(split(chunk, line_bytes), num_requesters) for chunk in reopen())
    return Work(num_chunks * num_requesters, chunks)


def clocked_work(reopen: Reopen, line_bytes: int, num_requesters: int) -> Iterator[tuple[Tasks, ...]]:
    """For each requester a unit that makes its reads at their cycles, and one that makes its writes."""
    last = np.zeros(2 * num_requesters, np.int64)  # cycle of each unit's latest operation
    for chunk in reopen():
        pieces = split(chunk, line_bytes)
        is_write = pieces["kind"] == Kind.WRITE
        unit = 2 * pieces["requester"].astype(np.int64) + is_write
        issued = np.maximum(pieces["cycle"] - is_write, 0)  # a unit's write leaves it a cycle later
        order = np.argsort(unit, kind="stable")
        ends = np.cumsum(np.bincount(unit, minlength=len(last)))
        parts = np.split(order, ends[:-1])
        yield tuple(
            _clocked(pieces[own], issued[own], last[number : number + 1]) for number, own in enumerate(parts)
        )


def _clocked(pieces: np.ndarray, issued: np.ndarray, last: np.ndarray) -> Tasks:
    """A task, or none without pieces; what lies between two operations is the unit's to count. Advances `last`."""
    if len(pieces) == 0:
        return Tasks(np.zeros(1, np.int64), np.zeros(0, RECORD))
    between = np.diff(issued, prepend=last)
    if between.max() > _LONGEST_PAUSE:
        raise fail(
            f"{between.max()} cycles lie between two accesses, at most {_LONGEST_PAUSE} can be counted"
        )
    last[0] = issued[-1]
    records = np.zeros(len(pieces) + 1, RECORD)
    records["op"][-1] = Op.END
    records["compute"][:-1] = between
    _set_operations(records[:-1], pieces)
    return Tasks(np.array([0, len(records)], np.int64), records)


def _set_operations(records: np.ndarray, pieces: np.ndarray) -> None:
    records["address"] = pieces["address"]
    records["bytes"] = np.minimum(pieces["bytes"], _MOST_BYTES)
    records["op"] = np.where(pieces["kind"] == Kind.WRITE, Op.STORE, Op.LOAD)


def _tasks(pieces: np.ndarray, num_requesters: int | None) -> Tasks:
    """A task for each piece, or one for each requester."""
    if num_requesters is None:
        lengths = np.ones(len(pieces), np.int64)
    else:
        pieces = pieces[np.argsort(pieces["requester"], kind="stable")]
        lengths = np.bincount(pieces["requester"], minlength=num_requesters)

    starts = np.concatenate([[0], np.cumsum(lengths + 1)])  # an END behind each task's accesses
    records = np.zeros(int(starts[-1]), RECORD)
    records["op"] = Op.END
    is_access = np.ones(len(records), np.bool_)
    is_access[starts[1:] - 1] = False
    operations = np.zeros(len(pieces), RECORD)
    _set_operations(operations, pieces)
    records[is_access] = operations
    return Tasks(starts, records)
