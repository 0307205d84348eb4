"""What the records of a unit must be like to be played; both models ask here before they play any."""

from __future__ import annotations

import numpy as np

from archsim.errors import fail
from archsim.jit import compiled
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.model.unit.spec import NO_MEMORY
from archsim.trace.records import RECORD, Op, Tasks

_THREAD_OPS = (Op.LOCK, Op.UNLOCK)


def channel_ends(spec: PipelineSpec) -> tuple[list[int], list[int]]:
    """Of each channel the unit that emits into it and the one that takes from it. ArchsimError unless it has both."""
    ends: tuple[list[int], list[int]] = ([], [])
    for channel in range(spec.num_channels):
        producers = [unit for unit, stage in enumerate(spec.units) if channel in stage.outputs]
        consumers = [unit for unit, stage in enumerate(spec.units) if channel in stage.inputs]
        if len(producers) != 1 or len(consumers) != 1:
            raise fail(
                f"channel {channel}: {len(producers)} units emit into it, {len(consumers)} take from it"
            )
        ends[0].append(producers[0])
        ends[1].append(consumers[0])
    return ends


def checked_records(spec: PipelineSpec, names: tuple[str, ...], unit: int, tasks: Tasks) -> np.ndarray:
    """RECORD [n]: the records of one unit's tasks, one after the other. ArchsimError if one cannot be played."""
    records = np.require(tasks.records[tasks.starts[0] : tasks.starts[-1]], RECORD, ["C", "A", "W"])
    closing = tasks.starts[1:] - tasks.starts[0] - 1
    if np.any(np.diff(tasks.starts) < 1) or np.any(records["op"][closing] != Op.END):
        raise fail(f"unit {names[unit]}: a task does not close with END")
    if np.count_nonzero(records["op"] == Op.END) != len(closing):
        raise fail(f"unit {names[unit]}: a task goes on behind its END")

    wrong = _first_wrong(records, _limits(spec, unit), _item_limits(spec, unit))
    if wrong < len(records):
        raise fail(f"unit {names[unit]}: {_why(spec, unit, records, int(wrong))}")
    return records


def _limits(spec: PipelineSpec, unit: int) -> np.ndarray:
    """int64 [Op]: the number of things that the operation's `address` may name, 0 if the unit has none."""
    stage = spec.units[unit]
    limits = np.zeros(len(Op), np.int64)
    limits[Op.TAKE] = len(stage.inputs)
    limits[Op.EMIT] = limits[Op.MARK] = len(stage.outputs)
    limits[Op.ACQUIRE] = limits[Op.RELEASE] = len(stage.pools)
    limits[Op.LOAD] = limits[Op.STORE] = 0 if stage.memory == NO_MEMORY else np.iinfo(np.int64).max
    has_clear_bits = stage.memory >= 0 and spec.caches[stage.memory].clear.block_bytes > 0
    limits[Op.CLEAR] = np.iinfo(np.int64).max if has_clear_bits else 0
    return limits


def _item_limits(spec: PipelineSpec, unit: int) -> np.ndarray:
    """int64 [outputs + 1]: the largest item of each output that is a delay stream, else 0."""
    limits = np.zeros(len(spec.units[unit].outputs) + 1, np.int64)
    for position, channel in enumerate(spec.units[unit].outputs):
        if channel >= len(spec.fifos):
            stream = spec.delay_streams[channel - len(spec.fifos)]
            limits[position] = min(stream.ring_bytes, stream.prefetch_bytes)
    return limits


@compiled
def _first_wrong(records, limits, item_limits):
    """Index of the first record that cannot be played, else their number."""
    is_first = True
    for i in range(len(records)):
        op, address, num_bytes = records[i]["op"], records[i]["address"], records[i]["bytes"]
        if records[i]["compute"] < 0 or op < 0 or op >= len(limits):
            return i
        if is_first and limits[Op.TAKE] > 0 and (op != Op.TAKE or records[i]["compute"] > 0):
            return i
        is_first = op == Op.END
        if is_first:
            continue
        if address < 0 or address >= limits[op]:
            return i
        if (op == Op.LOAD or op == Op.STORE or op == Op.CLEAR) and num_bytes < 1:
            return i
        if op == Op.EMIT and (
            num_bytes > item_limits[address] or (num_bytes < 1) != (item_limits[address] == 0)
        ):
            return i
        if op == Op.MARK and item_limits[address] == 0:
            return i
    return len(records)


def _why(spec: PipelineSpec, unit: int, records: np.ndarray, wrong: int) -> str:
    """Why a record cannot be played."""
    address, compute, num_bytes, number = records[wrong].tolist()
    if not 0 <= number < len(Op):
        return f"no operation has the number {number}"
    op = Op(number)
    if compute < 0:
        return f"{op.name} after {compute} steps"
    opens = wrong == 0 or records[wrong - 1]["op"] == Op.END
    if opens and spec.units[unit].inputs and (op != Op.TAKE or compute):
        return "a task must open with TAKE, because the unit has inputs"
    limit = int(_limits(spec, unit)[op])
    if op in _THREAD_OPS:
        return f"{op.name} is an operation of threads"
    if limit == 0:
        return f"{op.name}: the unit has no {_NAMED[op]}"
    if op in (Op.LOAD, Op.STORE, Op.CLEAR) and address < 0:
        return f"{op.name} at address {address}: addresses begin at 0"
    if not 0 <= address < limit:
        return f"{op.name} of {_NAMED[op]} {address}: they are numbered from 0 to {limit - 1}"
    if op in (Op.LOAD, Op.STORE, Op.CLEAR):
        return f"{op.name} of {num_bytes} bytes"
    largest = int(_item_limits(spec, unit)[address])
    if largest == 0:
        return f"{op.name} of {num_bytes} bytes to output {address}, which is a fifo"
    what = f"a delay stream that holds items of 1 to {largest} bytes"
    return f"{op.name} of {num_bytes} bytes to output {address}: {what}"


_NAMED = {
    Op.LOAD: "memory",
    Op.STORE: "memory",
    Op.CLEAR: "cache with clear bits",
    Op.TAKE: "input",
    Op.EMIT: "output",
    Op.MARK: "output",
    Op.ACQUIRE: "pool",
    Op.RELEASE: "pool",
}
