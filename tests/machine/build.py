"""Small machines and small tasks for the tests of both timing models, and the mark that runs a test on both."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from archsim.machine import compiled, reference
from archsim.machine.counters import Counters
from archsim.machine.spec import MachineSpec
from archsim.model.cache.spec import DRAM_PARENT, CacheSpec
from archsim.model.causes import AtCache, AtDram
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.dram.spec import AddressField, DramSpec, DramTiming, PagePolicy, Scheduler
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks.spec import LocksSpec
from archsim.model.unit.spec import UnitSpec
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import Work, whole

both_models = pytest.mark.parametrize(
    "simulate", [reference.simulate, compiled.simulate], ids=["reference", "compiled"]
)

# A number of its own for every parameter, so that a wrong term cannot cancel.
TIMING = DramTiming(
    n_cl=11,
    n_wl=5,
    n_rcd_read=13,
    n_rcd_write=7,
    n_rp=17,
    n_ras=19,
    n_rc=23,
    n_rrd=3,
    n_rrd_l=3,
    n_faw=0,
    n_ccd=2,
    n_ccd_l=2,
    n_rtp=4,
    n_wr=31,
    n_wtr=37,
    n_wtr_l=37,
    n_rtw=41,
    n_rfc=43,
    n_refi=0,
)

# One burst of one clock is a line of 8 bytes; 16 lines a row, 4 banks, then rows.
DRAM = DramSpec(
    num_channels=1,
    num_banks=4,
    num_groups=1,
    period_ticks=1,
    burst_beats=2,
    clock_beats=2,
    beat_bytes=4,
    num_queue_entries=16,
    num_write_entries=0,
    write_high=0,
    write_low=0,
    scheduler=Scheduler.FR_FCFS,
    max_wait_clocks=1000,
    page_policy=PagePolicy.OPEN,
    page_timeout_clocks=0,
    channel=AddressField(shift=0, bits=0),
    group=AddressField(shift=0, bits=0),
    bank=AddressField(shift=7, bits=2),
    row=AddressField(shift=9, bits=8),
    line=AddressField(shift=3, bits=4),
    bank_hash=0,
    timing=TIMING,
)

CORE = CoreSpec(num_cores=1, num_threads=1, period_ticks=1, task_order=TaskOrder.INTERLEAVED)

CACHE = CacheSpec(
    num_sets=16,
    num_ways=4,
    line_bytes=8,
    hit_cycles=1,
    num_mshrs=16,
    num_targets=16,
    num_ports=16,
    parent=DRAM_PARENT,
)

# Cycles from a request's arrival at the DRAM to its fill, for MACHINE: one tick is a cycle and a clock.
OPEN_ROW = TIMING.n_cl + 1
CLOSED_BANK = TIMING.n_rcd_read + OPEN_ROW

MACHINE = MachineSpec(
    core=CORE,
    core_cache=(0,),
    locks=LocksSpec(num_locks=4),
    source=UnitSpec(interval_cycles=0),
    fifo=FifoSpec(num_entries=2),
    caches=(CACHE,),
    dram=DRAM,
)


def machine(num_cores: int = 1, num_threads: int = 1, **parts: Any) -> MachineSpec:
    """MACHINE with other numbers of cores and threads, and with `parts` replaced by name."""
    core = CORE._replace(num_cores=num_cores, num_threads=num_threads)
    return MACHINE._replace(core=core, core_cache=(0,) * num_cores)._replace(**parts)


def address(bank: int = 0, row: int = 0, column: int = 0) -> int:
    """Byte address of a line of DRAM."""
    return row << DRAM.row.shift | bank << DRAM.bank.shift | column * CACHE.line_bytes


def cached(*caches: CacheSpec, **parts: Any) -> MachineSpec:
    """A machine of one core over a chain of caches, the first the core's."""
    parents = [*range(1, len(caches)), DRAM_PARENT]
    chain = tuple(cache._replace(parent=parent) for cache, parent in zip(caches, parents, strict=True))
    return machine(caches=chain, **parts)


def load(where: int, num_bytes: int = 4) -> tuple[Op, int, int]:
    return Op.LOAD, where, num_bytes


def store(where: int, num_bytes: int = 4) -> tuple[Op, int, int]:
    return Op.STORE, where, num_bytes


def lock(number: int) -> tuple[Op, int, int]:
    return Op.LOCK, number, 0


def unlock(number: int) -> tuple[Op, int, int]:
    return Op.UNLOCK, number, 0


def clear(where: int, num_bytes: int) -> tuple[Op, int, int]:
    return Op.CLEAR, where, num_bytes


EMIT = (Op.EMIT, 0, 0)

Step = int | tuple[Op, int, int]  # a number of one-cycle instructions, or one operation


def records(steps: list[Step]) -> list[tuple[int, int, int, int]]:
    """The records of one task."""
    listed, compute = [], 0
    for step in steps:
        if isinstance(step, int):
            compute += step
        else:
            op, where, num_bytes = step
            listed.append((where, compute, num_bytes, op))
            compute = 0
    return [*listed, (0, compute, 0, Op.END)]


def tasks(*steps_of_tasks: list[Step]) -> Tasks:
    runs = [records(steps) for steps in steps_of_tasks]
    starts = np.cumsum([0, *(len(run) for run in runs)], dtype=np.int64)
    return Tasks(starts, np.array([record for run in runs for record in run], dtype=RECORD))


def work(*steps_of_tasks: list[Step]) -> Work:
    """A task for each argument: `work([3, load(8), EMIT], [])` is two tasks, the second empty."""
    return whole(tasks(*steps_of_tasks))


def stalls(counters: Counters, core: int = 0) -> dict[str, int]:
    """Empty slots of a core by cause, such as `0.mshr` for cache 0 or `dram.bus`; causes without slots are left out."""
    names = ["no_work", "lock", *cause_names(len(counters.cache_hits))]
    counts = counters.stalled[core].tolist()
    return {name: n for name, n in zip(names, counts, strict=True) if n}


def cause_names(num_caches: int) -> list[str]:
    """The causes of a wait for memory in the order of their numbers."""
    at_caches = [f"{cache}.{cause.name.lower()}" for cache in range(num_caches) for cause in AtCache]
    return [*at_caches, *(f"dram.{cause.name.lower()}" for cause in AtDram)]


def difference(ours: Counters, theirs: Counters) -> str:
    """The counters that differ, one a line; empty when all are equal."""
    lines = []
    for name, left, right in zip(Counters._fields, ours, theirs, strict=True):
        if not np.array_equal(left, right):
            lines.append(f"{name}: {np.asarray(left).tolist()} against {np.asarray(right).tolist()}")
    return "\n".join(lines)
