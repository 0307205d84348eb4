"""Small pipelines and small work for the tests of both timing models, and the mark that runs a test on both."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from archsim.machine.pipeline import compiled, reference
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.delay_stream.spec import DelayStreamSpec, Overflow
from archsim.model.fifo.spec import FifoSpec
from archsim.model.unit.spec import NO_MEMORY, StageSpec
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import PipelineWork
from tests.machine.build import CACHE, DRAM

both_models = pytest.mark.parametrize(
    "simulate", [reference.simulate, compiled.simulate], ids=["reference", "compiled"]
)

UNIT = StageSpec(
    interval_cycles=1,
    latency_cycles=1,
    lanes=1,
    inputs=(),
    outputs=(),
    pools=(),
    memory=NO_MEMORY,
    line_bytes=CACHE.line_bytes,
    outstanding=8,
    in_flight=8,
)
STREAM = DelayStreamSpec(
    ring_bytes=64, base=0, line_bytes=8, outstanding=4, prefetch_bytes=32, overflow=Overflow.STALL
)
FIFO = FifoSpec(num_entries=4)

END = (Op.END, 0, 0)


def take(number: int = 0) -> tuple[Op, int, int]:
    return Op.TAKE, number, 0


def emit(number: int = 0, num_bytes: int = 0) -> tuple[Op, int, int]:
    return Op.EMIT, number, num_bytes


def mark(number: int = 0) -> tuple[Op, int, int]:
    return Op.MARK, number, 0


def acquire(number: int = 0) -> tuple[Op, int, int]:
    return Op.ACQUIRE, number, 0


def release(number: int = 0) -> tuple[Op, int, int]:
    return Op.RELEASE, number, 0


def load(where: int, num_bytes: int = 4) -> tuple[Op, int, int]:
    return Op.LOAD, where, num_bytes


def clear(where: int, num_bytes: int) -> tuple[Op, int, int]:
    return Op.CLEAR, where, num_bytes


def store(where: int, num_bytes: int = 4) -> tuple[Op, int, int]:
    return Op.STORE, where, num_bytes


Step = int | tuple[Op, int, int]  # compute steps, or one operation
UnitTasks = list[list[Step]]


def machine(*units: StageSpec, **parts: Any) -> PipelineSpec:
    """A pipeline of these units over one DRAM; `parts` say what else there is."""
    spec = PipelineSpec(1, units, (), (), (), (), DRAM)
    return spec._replace(**parts)


def chain(*units: StageSpec, fifo: FifoSpec = FIFO, **parts: Any) -> PipelineSpec:
    """Units in a row with a fifo between each two."""
    last = len(units) - 1
    wired = [
        unit._replace(inputs=(k - 1,) if k > 0 else (), outputs=(k,) if k < last else ())
        for k, unit in enumerate(units)
    ]
    return machine(*wired, fifos=(fifo,) * last, **parts)


def delayed(
    first: StageSpec, second: StageSpec, stream: DelayStreamSpec = STREAM, **parts: Any
) -> PipelineSpec:
    """Two units with a delay stream between them."""
    units = first._replace(outputs=(0,)), second._replace(inputs=(0,))
    return machine(*units, delay_streams=(stream,), **parts)


def on_dram(unit: StageSpec = UNIT, **parts: Any) -> StageSpec:
    return unit._replace(memory=DRAM_PARENT, **parts)


def tasks(listed: UnitTasks) -> Tasks:
    """The tasks of one unit."""
    records, starts = [], [0]
    for steps in listed:
        compute = 0
        for step in [*steps, END]:
            if isinstance(step, int):
                compute += step
            else:
                op, where, num_bytes = step
                records.append((where, compute, num_bytes, op))
                compute = 0
        starts.append(len(records))
    return Tasks(np.array(starts, np.int64), np.array(records, dtype=RECORD))


def work(*units: UnitTasks) -> PipelineWork:
    """A single chunk with the tasks of every unit; the units are named a, b, c ..."""
    return chunks(units)


def chunks(*listed: tuple[UnitTasks, ...]) -> PipelineWork:
    names = tuple("abcdefgh"[: len(listed[0])])
    return PipelineWork(names, iter([tuple(tasks(unit) for unit in chunk) for chunk in listed]))


def difference(ours: PipelineCounters, theirs: PipelineCounters) -> str:
    """The counters that differ, one a line; empty when all are equal."""
    pairs = list(zip(PipelineCounters._fields[:-1], ours[:-1], theirs[:-1], strict=True))
    pairs += list(zip(ours.memory._fields, ours.memory, theirs.memory, strict=True))
    return "\n".join(
        f"{name}: {np.asarray(left).tolist()} against {np.asarray(right).tolist()}"
        for name, left, right in pairs
        if not np.array_equal(left, right)
    )
