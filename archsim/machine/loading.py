"""Tasks of a bounded stream, as far as they are needed: checked when they come, dropped when no thread wants them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from archsim.errors import ArchsimError, fail
from archsim.jit import compiled
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

    records = np.require(chunk.records[chunk.starts[0] : chunk.starts[-1]], RECORD, ["C", "A", "W"])
    chunk_starts = (chunk.starts - chunk.starts[0]).astype(np.int64)
    _check(spec, chunk_starts, records)
    kept = loaded.starts[first_needed - loaded.first_task :]
    num_kept = int(loaded.starts[-1] - kept[0])
    if num_kept > 0:
        records = np.concatenate([loaded.records[kept[0] : loaded.starts[-1]], records])
    starts = np.concatenate([kept[:-1] - kept[0], chunk_starts + num_kept])
    return Loaded(first_needed, loaded.num_tasks, starts, records)


def _check(spec: MachineSpec, starts: np.ndarray, records: np.ndarray) -> None:
    """ArchsimError if a record cannot be played on the machine."""
    if np.any(records["op"][starts[1:] - 1] != Op.END):
        raise fail("a task does not close with END")

    line_bytes = min((spec.caches[cache].line_bytes for cache in spec.core_cache), default=1)
    wrong = _first_wrong(records, spec.locks.num_locks, line_bytes)
    if wrong < len(records):
        raise _refused(spec, records[wrong], line_bytes)


@compiled
def _first_wrong(records, num_locks, line_bytes):
    """Index of the first record with a lock that is not there or an access that crosses a line, else their number."""
    for i in range(len(records)):
        address, op = records[i]["address"], records[i]["op"]
        if op == Op.LOAD or op == Op.STORE:
            offset = address & (line_bytes - 1)
            if address < 0 or offset + records[i]["bytes"] > line_bytes:
                return i
        elif (op == Op.LOCK or op == Op.UNLOCK) and (address < 0 or address >= num_locks):
            return i
    return len(records)


def _refused(spec: MachineSpec, record: np.void, line_bytes: int) -> ArchsimError:
    """Why a record cannot be played."""
    operation, address = Op(record["op"]).name, record["address"]
    if record["op"] in (Op.LOCK, Op.UNLOCK):
        return fail(f"{operation} of lock {address}: there are {spec.locks.num_locks} locks")
    if address < 0:
        return fail(f"{operation} at address {address}: addresses begin at 0")
    last = address + record["bytes"] - 1
    return fail(f"{operation} of addresses {address} to {last} crosses a line of {line_bytes} bytes")
