"""One thread at a time: the timed caches count what the caches without time do, and so what Dinero IV does."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from archsim.model.cache.functional import counts_of, new_chain, replay
from archsim.model.cache.spec import Arbiter, CacheSpec, Replacement, VictimOrder, WritePolicy
from tests.machine.build import CACHE, both_models, cached, load, store, work

pytestmark = both_models
ACCESS_BYTES = 4
PAUSE = 150  # cycles in which everything that is on its way arrives


@st.composite
def levels(draw: st.DrawFn) -> CacheSpec:
    line = draw(st.sampled_from([8, 16, 32]))
    return CACHE._replace(
        num_sets=draw(st.sampled_from([1, 2, 4])),
        num_ways=draw(st.sampled_from([1, 2, 4, 16])),
        line_bytes=line,
        num_sectors=draw(st.sampled_from([n for n in (1, 2, 4) if line // n >= 8])),
        hit_cycles=draw(st.integers(1, 5)),
        replacement=draw(st.sampled_from(Replacement)),
        seed=draw(st.integers(0, 9)),
        write_policy=draw(st.sampled_from(WritePolicy)),
        allocates_writes=draw(st.integers(0, 1)),
        victim_order=draw(st.sampled_from(VictimOrder)),
        num_write_entries=draw(st.integers(0, 2)),
        arbiter=draw(st.sampled_from(Arbiter)),
    )


def is_alike(specs: list[CacheSpec]) -> bool:
    """Several parts of a line come at a time; LRU and FIFO then choose as if one came after the other."""
    by_age = (Replacement.LRU, Replacement.FIFO)
    pairs = pairwise(specs)
    return all(above.line_bytes <= below.line_bytes or below.replacement in by_age for above, below in pairs)


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(specs=st.lists(levels(), min_size=1, max_size=3).filter(is_alike), seed=st.integers(0, 2**32))
def test_the_counts_are_those_without_time(simulate, specs, seed):
    rng = np.random.default_rng(seed)
    accesses = [
        (int(word) * ACCESS_BYTES, bool(w))
        for word, w in zip(rng.integers(0, 64, 24), rng.random(24) < 0.4, strict=True)
    ]
    steps = [step for where, writes in accesses for step in ((store if writes else load)(where), PAUSE)]
    counters = simulate(cached(*specs), work(steps))

    chain = new_chain(specs)
    where, writes = zip(*accesses, strict=True)
    replay(chain, np.array(where), np.full(len(where), ACCESS_BYTES), np.array(writes))
    *wanted, memory = counts_of(chain)
    for k, level in enumerate(wanted):
        assert counters.cache_reads[k] == level.reads
        assert counters.cache_misses[k] == level.read_misses + level.write_misses, f"level {k}"
        assert counters.cache_writebacks_out[k] + counters.cache_writethroughs_out[k] >= level.writebacks
    assert counters.dram_reads.sum() == memory.reads
    assert counters.dram_writes.sum() == memory.writes
