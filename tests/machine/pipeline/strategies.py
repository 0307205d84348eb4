"""Random pipelines and random work for the differential and the conservation tests."""

from __future__ import annotations

from typing import NamedTuple

from hypothesis import strategies as st

from archsim.machine.pipeline.spec import PipelineSpec
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.delay_stream.spec import DelayStreamSpec, Overflow
from archsim.model.fifo.spec import FifoSpec
from archsim.model.pool.spec import PoolSpec
from archsim.model.unit.spec import NO_MEMORY, StageSpec
from tests.machine.pipeline.build import UnitTasks, acquire, clear, emit, load, mark, release, store, take
from tests.machine.strategies import ACCESS_BYTES, ADDRESS_BYTES, PERIODS, drams, small, trees

LINE_BYTES = 16  # of the DRAM, and of a unit's access to it
RING_BYTES = 64
ITEM_BYTES = 20


class Case(NamedTuple):
    """A pipeline and its work, cut in chunks."""

    spec: PipelineSpec
    chunks: tuple[tuple[UnitTasks, ...], ...]


@st.composite
def stages(draw: st.DrawFn, number: int, num_units: int, num_caches: int, has_pool: bool) -> StageSpec:
    """A unit between channel `number - 1` and channel `number`."""
    return StageSpec(
        interval_cycles=draw(small(3)),
        latency_cycles=draw(small(5)),
        lanes=draw(small(3)),
        inputs=(number - 1,) if number > 0 else (),
        outputs=(number,) if number < num_units - 1 else (),
        pools=(0,) if has_pool and number in (0, num_units - 1) else (),
        memory=draw(st.sampled_from([NO_MEMORY, DRAM_PARENT, *range(num_caches)])),
        line_bytes=LINE_BYTES,
        outstanding=draw(small(4)),
        in_flight=draw(small(6)),
    )


def delay_streams() -> st.SearchStrategy[DelayStreamSpec]:
    return st.builds(
        DelayStreamSpec,
        ring_bytes=st.just(RING_BYTES),
        base=st.just(ADDRESS_BYTES),
        line_bytes=st.just(LINE_BYTES),
        outstanding=small(3),
        prefetch_bytes=st.sampled_from([ITEM_BYTES, 2 * ITEM_BYTES]),
        overflow=st.just(Overflow.RELEASE),
    )


@st.composite
def specs(draw: st.DrawFn) -> PipelineSpec:
    """A chain of two to four units; its last channel may be a delay stream; the first and last may share a pool."""
    ticks, dram_ticks = draw(st.sampled_from(PERIODS))
    tree, _ = draw(trees(1))
    tree = tree if draw(st.booleans()) else ()
    num_units = draw(small(4, 2))
    has_pool, has_stream = draw(st.booleans()), draw(st.booleans())
    num_fifos = num_units - 1 - has_stream
    units = tuple(draw(stages(number, num_units, len(tree), has_pool)) for number in range(num_units))
    units = tuple(
        unit._replace(line_bytes=tree[unit.memory].line_bytes if unit.memory >= 0 else LINE_BYTES)
        for unit in units
    )
    return PipelineSpec(
        period_ticks=ticks,
        units=units,
        fifos=tuple(FifoSpec(draw(small(3))) for _ in range(num_fifos)),
        delay_streams=(draw(delay_streams()),) if has_stream else (),
        pools=(PoolSpec(draw(small(2))),) if has_pool else (),
        caches=tree,
        dram=draw(drams(dram_ticks, LINE_BYTES)),
    )


@st.composite
def steps_of(draw: st.DrawFn, spec: PipelineSpec, unit: StageSpec) -> list:
    """Compute steps and accesses in any order."""
    accesses = [load, load, store]
    if unit.memory >= 0 and spec.caches[unit.memory].clear.block_bytes > 0:
        accesses.append(clear)
    steps: list = []
    for _ in range(draw(st.integers(0, 3))):
        word = draw(st.one_of(st.integers(0, 15), st.integers(0, ADDRESS_BYTES // ACCESS_BYTES - 20)))
        num_bytes = draw(st.sampled_from([1, 4, 16, 40]))
        access = draw(st.sampled_from(accesses))
        is_access = unit.memory != NO_MEMORY and draw(st.booleans())
        steps.append(access(word * ACCESS_BYTES, num_bytes) if is_access else draw(small(5)))
    return steps


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """Work in chunks, each of which is one group: a token, if there is a pool, some items and a marker."""
    spec = draw(specs())
    groups = draw(st.lists(st.lists(small(ITEM_BYTES), min_size=1, max_size=6), max_size=4))
    return Case(
        spec, tuple(tuple(draw(group_of(spec, k, sizes)) for k in range(len(spec.units))) for sizes in groups)
    )


@st.composite
def group_of(draw: st.DrawFn, spec: PipelineSpec, number: int, sizes: list[int]) -> UnitTasks:
    """A task for each item of the group."""
    unit, tasks = spec.units[number], []
    for place, size in enumerate(sizes):
        steps: list = [take()] if unit.inputs else []
        if unit.pools and number == 0 and place == 0:
            steps.append(acquire())
        steps += draw(steps_of(spec, unit))
        if unit.outputs:
            is_stream = unit.outputs[0] >= len(spec.fifos)
            steps.append(emit(0, size if is_stream else 0))
            if is_stream and place == len(sizes) - 1:
                steps.append(mark())
        elif unit.pools and place == len(sizes) - 1:
            steps.append(release())
        tasks.append(steps + draw(steps_of(spec, unit)))
    return tasks
