"""What tasks must be like to be played on a machine; both models ask here before they play any."""

from __future__ import annotations

import numpy as np

from archsim.errors import ArchsimError, fail
from archsim.jit import compiled
from archsim.machine.spec import MachineSpec
from archsim.trace.records import Op


def check_tasks(spec: MachineSpec, starts: np.ndarray, records: np.ndarray) -> None:
    """ArchsimError if a record cannot be played on the machine."""
    if np.any(records["op"][starts[1:] - 1] != Op.END):
        raise fail("a task does not close with END")

    line_bytes = min((spec.caches[cache].line_bytes for cache in spec.core_cache), default=1)
    has_clear_bits = all(spec.caches[cache].clear.block_bytes > 0 for cache in spec.core_cache)
    wrong = _first_wrong(records, spec.locks.num_locks, line_bytes, has_clear_bits)
    if wrong < len(records):
        raise _refused(spec, records[wrong], line_bytes)


@compiled
def _first_wrong(records, num_locks, line_bytes, has_clear_bits):
    """Index of the first record that cannot be played, else their number."""
    for i in range(len(records)):
        address, op = records[i]["address"], records[i]["op"]
        if op == Op.LOAD or op == Op.STORE:
            offset = address & (line_bytes - 1)
            if address < 0 or offset + records[i]["bytes"] > line_bytes:
                return i
        elif op == Op.CLEAR:
            if address < 0 or not has_clear_bits:
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
    if record["op"] == Op.CLEAR:
        return fail(f"CLEAR at address {address}: the core's cache has no clear bits")
    last = address + record["bytes"] - 1
    return fail(f"{operation} of addresses {address} to {last} crosses a line of {line_bytes} bytes")
