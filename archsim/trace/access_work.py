"""From accesses to work: what threads play when a trace is replayed with time.

Accesses that cross lines become one operation for each line. A requester makes its accesses in order, each when the one
before has been answered.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from archsim.trace.accesses import Accesses, Kind
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import Work

_MOST_BYTES = np.iinfo(
    np.int16
).max  # that a record can say; more in one line makes no difference to its time

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
    operations["address"] = pieces["address"]
    operations["bytes"] = np.minimum(pieces["bytes"], _MOST_BYTES)
    operations["op"] = np.where(pieces["kind"] == Kind.WRITE, Op.STORE, Op.LOAD)
    records[is_access] = operations
    return Tasks(starts, records)
