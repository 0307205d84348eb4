"""Random machines and random work for the differential and the conservation tests."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from archsim.machine.spec import MachineSpec
from archsim.model.cache.spec import (
    DRAM_PARENT,
    NO_CLEAR_BITS,
    Arbiter,
    CacheSpec,
    ClearSpec,
    Replacement,
    VictimOrder,
    WritePolicy,
)
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.dram.spec import AddressField, DramSpec, DramTiming, PagePolicy, Scheduler
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks.spec import LocksSpec
from archsim.model.unit.spec import UnitSpec
from archsim.trace.records import Op, Tasks
from tests.machine.build import EMIT, Step, clear, load, lock, store, tasks, unlock

PERIODS = [(7, 12), (1, 1), (5, 3), (3, 2), (2, 6), (4, 1)]  # ticks of a core cycle and of a memory clock
NUM_LOCKS = 2
ADDRESS_BYTES = 4096  # few enough that tasks meet in lines, sets, rows and banks
ACCESS_BYTES = 4


def small(most: int, least: int = 1) -> st.SearchStrategy[int]:
    return st.integers(least, most)


@st.composite
def timings(draw: st.DrawFn, num_groups: int) -> DramTiming:
    """Any constraint may be the one that binds; refresh leaves time to serve a request between two."""
    drawn_apart = ("n_refi", "n_faw", "n_ccd", "n_ccd_l", "n_rrd_l", "n_wtr_l")
    clocks = {name: draw(small(12)) for name in DramTiming._fields if name not in drawn_apart}
    clocks["n_ccd"] = draw(small(6))
    for name in ("n_rrd", "n_ccd", "n_wtr"):
        clocks[f"{name}_l"] = clocks[name] + (draw(small(8, 0)) if num_groups > 1 else 0)
    clocks["n_faw"] = draw(st.sampled_from([0, 0, 20, 45]))
    cost = sum(clocks.values())
    return DramTiming(**clocks, n_refi=draw(st.sampled_from([0, 0, cost + 60, 2 * cost + 101])))


@st.composite
def address_fields(draw: st.DrawFn) -> dict[str, AddressField]:
    """The bits of the address in a random order above the line; `line` is used to record commands only."""
    bits = {"channel": draw(small(1, 0)), "bank": draw(small(2, 0)), "row": draw(small(3, 0))}
    bits["group"] = draw(small(1, 0))
    shift = draw(st.sampled_from([3, 4, 5, 6, 7]))
    fields = {"line": AddressField(3, shift - 3)}
    for name in draw(st.permutations(sorted(bits))):
        fields[name] = AddressField(shift, bits[name])
        shift += bits[name]
    return fields


@st.composite
def queues(draw: st.DrawFn) -> dict[str, int]:
    """The scheduler, and a write queue where there may be one."""
    scheduler = draw(st.sampled_from([Scheduler.FCFS, *[Scheduler.FR_FCFS] * 3, Scheduler.IDEAL]))
    entries = 0 if scheduler == Scheduler.IDEAL else draw(st.sampled_from([0, 0, 1, 2, 3, 6]))
    high = draw(small(entries)) if entries else 0
    low = draw(small(high - 1, 0)) if high else 0
    return {"scheduler": scheduler, "num_write_entries": entries, "write_high": high, "write_low": low}


@st.composite
def drams(draw: st.DrawFn, period_ticks: int, line_bytes: int) -> DramSpec:
    """One or two channels, one to eight banks."""
    burst_bytes = draw(st.sampled_from([size for size in (8, 16, 32) if size <= line_bytes]))
    clock_beats = draw(st.sampled_from([2, 2, 4]))
    burst_beats = draw(st.sampled_from([beats for beats in (2, 4, 8) if beats >= clock_beats]))
    fields = draw(address_fields())
    num_groups = 1 << fields["group"].bits
    bank_bits = fields["bank"].bits + fields["group"].bits
    return DramSpec(
        num_channels=1 << fields["channel"].bits,
        num_banks=1 << bank_bits,
        num_groups=num_groups,
        period_ticks=period_ticks,
        burst_beats=burst_beats,
        clock_beats=clock_beats,
        beat_bytes=burst_bytes // burst_beats,
        num_queue_entries=draw(small(4)),
        max_wait_clocks=draw(st.sampled_from([0, 5, 30, 1000])),
        page_policy=draw(st.sampled_from(PagePolicy)),
        page_timeout_clocks=draw(st.sampled_from([1, 3, 20, 100])),
        bank_hash=draw(st.sampled_from([0, bank_bits])),
        timing=draw(timings(num_groups)),
        **draw(queues()),
        **fields,
    )


@st.composite
def clear_bits(draw: st.DrawFn) -> ClearSpec:
    """Bits for some of the memory that is used, or none."""
    if not draw(st.booleans()):
        return NO_CLEAR_BITS
    block = draw(st.sampled_from([4, 8, 16, 64]))
    first = draw(st.sampled_from([0, 64, 1024]))
    return ClearSpec(
        block, first, draw(st.sampled_from([1, 5, ADDRESS_BYTES // block])), draw(st.integers(0, 1))
    )


@st.composite
def policies(draw: st.DrawFn, line_bytes: int, least_sector: int) -> dict[str, Any]:
    """One cache in three is plain; the others differ from it in anything."""
    if draw(small(3)) == 1:
        return {}
    sectors = [n for n in (1, 2, 4) if line_bytes // n >= least_sector]
    return {
        "num_sectors": draw(st.sampled_from(sectors)),
        "replacement": draw(st.sampled_from(Replacement)),
        "seed": draw(st.integers(0, 3)),
        "write_policy": draw(st.sampled_from(WritePolicy)),
        "allocates_writes": draw(st.integers(0, 1)),
        "victim_order": draw(st.sampled_from(VictimOrder)),
        "num_write_entries": draw(st.integers(0, 2)),
        "arbiter": draw(st.sampled_from(Arbiter)),
        "clear": draw(clear_bits()),
    }


@st.composite
def caches(draw: st.DrawFn, line_bytes: int, parent: int) -> CacheSpec:
    return CacheSpec(
        num_sets=draw(st.sampled_from([1, 2, 4])),
        num_ways=draw(small(3) if draw(small(4)) > 1 else st.sampled_from([9, 17])),  # or more than LANES
        line_bytes=line_bytes,
        hit_cycles=draw(small(4)),
        num_mshrs=draw(small(4)),
        num_targets=draw(small(3)),
        num_ports=draw(small(3)),
        parent=parent,
        **draw(policies(line_bytes, ACCESS_BYTES)),
    )


@st.composite
def trees(draw: st.DrawFn, num_cores: int) -> tuple[tuple[CacheSpec, ...], tuple[int, ...]]:
    """One to three levels, and each core's cache. The first level is private or shared; a core may skip it.

    Mostly lines get longer from level to level.
    """
    num_levels = draw(small(3))
    num_first = num_cores if draw(st.booleans()) else 1
    line_bytes = draw(st.lists(st.sampled_from([8, 16, 32]), min_size=num_levels, max_size=num_levels))
    if draw(small(3)) > 1:
        line_bytes.sort()
    widths = [num_first] + [1] * (num_levels - 1)
    made: list[CacheSpec] = []
    for level in range(num_levels):
        parent = DRAM_PARENT if level == num_levels - 1 else sum(widths[: level + 1])
        made += [draw(caches(line_bytes[level], parent)) for _ in range(widths[level])]
    core_cache = [min(core, num_first - 1) for core in range(num_cores)]
    if num_levels > 1 and draw(st.booleans()):
        core_cache[-1] = num_first
    return tuple(made), tuple(core_cache)


@st.composite
def machines(draw: st.DrawFn) -> MachineSpec:
    """In one of three all caches have clear bits."""
    core_ticks, dram_ticks = draw(st.sampled_from(PERIODS))
    core = CoreSpec(draw(small(3)), draw(small(4)), core_ticks, draw(st.sampled_from(TaskOrder)))
    tree, core_cache = draw(trees(core.num_cores))
    if draw(small(3)) == 1:
        bits = draw(clear_bits().filter(lambda bits: bits.block_bytes > 0))
        tree = tuple(cache._replace(clear=bits) for cache in tree)
    return MachineSpec(
        core=core,
        core_cache=core_cache,
        locks=LocksSpec(NUM_LOCKS, is_ideal=draw(st.integers(0, 9)) == 0),
        source=UnitSpec(draw(st.sampled_from([0, 1, 3, 10]))),
        fifo=FifoSpec(draw(small(3, 0))),
        caches=tree,
        dram=draw(drams(dram_ticks, tree[-1].line_bytes)),
    )


def accesses() -> st.SearchStrategy[Step]:
    """A LOAD or a STORE of a word or two, near others as often as far from them."""
    near = st.integers(0, 31)
    far = st.integers(0, ADDRESS_BYTES // ACCESS_BYTES - 1)
    where = st.one_of(near, far).map(lambda word: word * ACCESS_BYTES)
    two_words = where.map(lambda address: address // 8 * 8)
    return st.one_of(
        where.map(load), where.map(store), two_words.map(lambda address: store(address, 2 * ACCESS_BYTES))
    )


def clears() -> st.SearchStrategy[Step]:
    return st.builds(clear, st.integers(0, ADDRESS_BYTES), st.integers(0, 200))


def plain_steps() -> st.SearchStrategy[list[Step]]:
    steps = st.one_of(st.integers(1, 6), accesses(), accesses(), st.just(EMIT), clears())
    return st.lists(steps, max_size=5)


@st.composite
def steps_of_task(draw: st.DrawFn) -> list[Step]:
    """Plain steps, perhaps followed by a critical section; one lock at a time, so nothing can get stuck."""
    steps = draw(plain_steps())
    if draw(st.booleans()):
        number = draw(st.integers(0, NUM_LOCKS - 1))
        steps += [lock(number), *draw(plain_steps()), unlock(number)]
    return steps


def few_tasks() -> st.SearchStrategy[Tasks]:
    """Work that hypothesis can shrink to the steps that matter."""
    return st.lists(steps_of_task(), max_size=12).map(lambda listed: tasks(*listed))


def drawn_steps(rng: np.random.Generator, most: int, num_words: int) -> list[Step]:
    """Up to `most` steps, five in seven of them accesses to one or two of `num_words` words."""
    steps: list[Step] = []
    for choice in rng.integers(0, 42, rng.integers(0, most + 1)):
        where = int(rng.integers(0, num_words)) * ACCESS_BYTES
        two_words = store(where // 8 * 8, 2 * ACCESS_BYTES)
        other = clear(where, 5 * int(choice)) if choice < 3 else EMIT
        kinds = [other, load(where), load(where), store(where), store(where), two_words, where % 7 + 1]
        steps.append(kinds[choice // 6])
    return steps


def drawn_tasks(seed: int, num_tasks: int, num_words: int) -> Tasks:
    """Dense work: one task in two closes with a critical section."""
    rng = np.random.default_rng(seed)
    listed = []
    for _ in range(num_tasks):
        steps = drawn_steps(rng, 8, num_words)
        if rng.integers(0, 2):
            number = int(rng.integers(0, NUM_LOCKS))
            steps += [lock(number), *drawn_steps(rng, 3, num_words), unlock(number)]
        listed.append(steps)
    return tasks(*listed)


def many_tasks() -> st.SearchStrategy[Tasks]:
    """Work that keeps a machine busy; hypothesis draws its seed and its shape only."""
    num_words = st.sampled_from([16, 64, 256, ADDRESS_BYTES // ACCESS_BYTES])
    return st.builds(drawn_tasks, st.integers(0, 2**32), st.integers(4, 40), num_words)


@st.composite
def plays(draw: st.DrawFn, work: st.SearchStrategy[Tasks]) -> tuple[MachineSpec, Tasks]:
    """A machine and work for it: without CLEARs if a core's cache has no clear bits."""
    spec, drawn = draw(machines()), draw(work)
    if all(spec.caches[cache].clear.block_bytes > 0 for cache in spec.core_cache):
        return spec, drawn
    records = drawn.records.copy()
    records["op"][records["op"] == Op.CLEAR] = Op.EMIT
    return spec, Tasks(drawn.starts, records)
