"""Caches without time count what Dinero IV counts, and what a page of paper says for the policies it lacks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from archsim.model.cache.functional import LevelCounts, copy_back, counts_of, new_chain, replay
from archsim.model.cache.spec import CacheSpec, Replacement, VictimOrder, WritePolicy
from tests.machine.build import CACHE
from tests.model.cache import dinero

ONE_SET = CACHE._replace(num_sets=1, num_ways=4, line_bytes=16)


def played(specs, requests, flush=False) -> list[LevelCounts]:
    chain = new_chain(specs)
    addresses, sizes, writes = zip(*requests, strict=True) if requests else ((), (), ())
    replay(chain, np.array(addresses, np.int64), np.array(sizes, np.int64), np.array(writes, np.bool_))
    if flush:
        copy_back(chain)
    return counts_of(chain)


def reads(*lines: int):
    return [(16 * line, 4, False) for line in lines]


@st.composite
def levels(draw: st.DrawFn) -> CacheSpec:
    line = draw(st.sampled_from([4, 8, 16, 32]))
    return CACHE._replace(
        num_sets=draw(st.sampled_from([1, 2, 4])),
        num_ways=draw(st.integers(1, 5) | st.sampled_from([9, 17])),
        line_bytes=line,
        num_sectors=draw(st.sampled_from([n for n in (1, 2, 4, 8) if n <= line])),
        replacement=draw(st.sampled_from([Replacement.LRU, Replacement.FIFO])),
        write_policy=draw(st.sampled_from(WritePolicy)),
        allocates_writes=draw(st.integers(0, 1)),
    )


@st.composite
def streams(draw: st.DrawFn) -> list[tuple[int, int, bool]]:
    """Hundreds of accesses, drawn by a seed, some across lines."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    num, span, most = (
        draw(st.integers(0, 300)),
        draw(st.sampled_from([64, 256, 1024])),
        draw(st.sampled_from([1, 4, 40])),
    )
    addresses, sizes = rng.integers(0, span, num), rng.integers(1, most + 1, num)
    return list(zip(addresses.tolist(), sizes.tolist(), (rng.random(num) < 0.4).tolist(), strict=True))


@settings(max_examples=500, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.lists(levels(), min_size=1, max_size=3), streams(), st.booleans())
def test_the_counts_are_those_of_dinero(specs, requests, flush):
    found = played(specs, requests, flush)
    wanted = dinero.replay(specs, requests, flush)
    for level, (mine, its) in enumerate(zip(found, wanted, strict=True)):
        assert mine._asdict() == {name: its[name] for name in LevelCounts._fields}, f"level {level}"


def test_chunks_do_not_matter():
    requests = [(64 * i % 4000, 4, i % 3 == 0) for i in range(500)]
    chain = new_chain([ONE_SET])
    for first in range(0, 500, 7):
        addresses, sizes, writes = zip(*requests[first : first + 7], strict=True)
        replay(chain, np.array(addresses, np.int64), np.array(sizes, np.int64), np.array(writes, np.bool_))

    assert counts_of(chain) == played([ONE_SET], requests)


@pytest.mark.parametrize(
    ("replacement", "misses"), [(Replacement.LRU, 6), (Replacement.FIFO, 7), (Replacement.TREE_PLRU, 5)]
)
def test_the_policies_differ_as_computed_by_hand(replacement, misses):
    """Four ways take 0 1 2 3, 0 hits, 4 misses. LRU drops 1 for it: 0 hits, 1 misses. FIFO drops 0: 0 and then 1 miss.
    The tree's root points away from 0 to the pair (2, 3), which points away from 3, so 2 leaves: 0 and 1 hit."""
    [level, memory] = played([ONE_SET._replace(replacement=replacement)], reads(0, 1, 2, 3, 0, 4, 0, 1))

    assert (level.read_misses, memory.reads) == (misses, misses)


def test_random_replacement_depends_on_its_seed_alone():
    requests = reads(*np.random.default_rng(3).integers(0, 6, 1000).tolist())
    caches = [ONE_SET._replace(replacement=Replacement.RANDOM, seed=seed) for seed in (5, 5, 6)]
    first, same, other = (played([cache], requests) for cache in caches)

    assert first == same
    assert first != other


def test_random_replacement_is_even():
    """Two new lines in a full set: the second drives the first out once in four times."""
    cache = ONE_SET._replace(replacement=Replacement.RANDOM, seed=1)
    again = [line for first in range(0, 40_000, 2) for line in (first, first + 1, first)]
    [level, _] = played([cache], reads(*again))

    stayed = 1 - (level.read_misses - 40_000) / 20_000
    assert abs(stayed - 3 / 4) < 0.02


def test_a_victim_that_is_written_back_first_finds_its_line_in_the_next_level():
    """Both levels hold one line. Line 1 drives 0 out of the L2 before 0 comes back, or after."""
    first, second = CACHE._replace(num_sets=1, num_ways=1), CACHE._replace(num_sets=1, num_ways=1)
    requests = [(0, 4, True), (8, 4, False)]
    late = played([first, second], requests)[1]
    early = played([first._replace(victim_order=VictimOrder.WRITE_BACK_FIRST), second], requests)[1]

    assert (late.read_misses, late.write_misses, late.fetches) == (2, 1, 2)
    assert (early.read_misses, early.write_misses, early.fetches) == (2, 0, 2)


def test_a_line_longer_than_the_next_level_s_is_fetched_in_parts():
    found = played([ONE_SET, CACHE], reads(0))

    assert (found[0].fetches, found[1].reads, found[1].read_misses, found[2].reads) == (1, 2, 2, 2)
