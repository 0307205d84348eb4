"""What replacement, writes, sectors, clear bits, the order of victims and the arbiter change, one behaviour each.

The DRAM's answers take CLOSED_BANK, later OPEN_ROW cycles; see tests/machine/build.py. Lines are 8 bytes there.
"""

from __future__ import annotations

import pytest

from archsim.errors import ArchsimError
from archsim.model.cache.spec import (
    Arbiter,
    ClearSpec,
    Replacement,
    VictimOrder,
    WritePolicy,
)
from tests.machine.build import (
    CACHE,
    CLOSED_BANK,
    address,
    both_models,
    cached,
    clear,
    load,
    machine,
    stalls,
    store,
    work,
)

pytestmark = both_models

A, B, C, D, E = (address(column=column) for column in (0, 2, 4, 6, 8))
ONE_LINE = CACHE._replace(num_sets=1, num_ways=1)
FOUR_LINES = CACHE._replace(num_sets=1, num_ways=4)
THROUGH = CACHE._replace(write_policy=WritePolicy.WRITE_THROUGH)
SECTORED = CACHE._replace(line_bytes=32, num_sectors=4)
LONG = 300  # cycles in which everything that is on its way arrives


def loads(*where: int):
    return work([load(each) for each in where])


@pytest.mark.parametrize(
    ("replacement", "misses"), [(Replacement.LRU, 6), (Replacement.FIFO, 7), (Replacement.TREE_PLRU, 5)]
)
def test_the_policy_names_the_victim(simulate, replacement, misses):
    """A B C D fill the set, A hits, E misses. LRU drops B, FIFO drops A. The tree points away from A to the pair
    (C, D) and there away from D: C leaves, A and B hit."""
    cache = FOUR_LINES._replace(replacement=replacement)

    assert simulate(cached(cache), loads(A, B, C, D, A, E, A, B)).cache_misses.tolist() == [misses]


def test_random_victims_depend_on_the_seed(simulate):
    """Over and over five lines in four ways."""
    found = {
        int(
            simulate(
                cached(FOUR_LINES._replace(replacement=Replacement.RANDOM, seed=seed)), stream
            ).cache_misses[0]
        )
        for seed in (1, 2, 3, 1)
        for stream in [loads(*[A, B, C, D, E] * 20)]
    }

    assert 1 < len(found) <= 3
    assert min(found) < 100  # LRU misses always


@pytest.mark.parametrize("replacement", Replacement)
def test_a_line_on_its_way_is_passed_over(simulate, replacement):
    """Two ways. A is here and used after B was asked for, which LRU and the tree would drop for C; B is on its way."""
    cache = CACHE._replace(num_sets=1, num_ways=2, replacement=replacement)
    spec = machine(num_threads=2, caches=(cache,))
    counters = simulate(spec, work([load(A), load(B), LONG, load(B), load(A)], [30, load(A), load(C)]))

    assert (counters.cache_misses[0], counters.cache_hits[0]) == (4, 2)
    assert counters.cache_blocked.tolist() == [0]


def test_a_write_that_goes_through_is_sent_at_once_and_leaves_the_line_clean(simulate):
    cache = THROUGH._replace(num_sets=1, num_ways=1)
    counters = simulate(cached(cache), work([load(A), store(A), load(B), LONG]))

    assert counters.cache_writethroughs_out.tolist() == [1]
    assert counters.cache_writebacks_out.tolist() == [0]
    assert counters.dram_writes.tolist() == [1]
    assert counters.cache_written_bytes.tolist() == [8]  # a burst


def test_a_write_that_goes_through_is_answered_at_the_hit_time(simulate):
    counters = simulate(cached(THROUGH._replace(hit_cycles=7)), work([load(A), store(A), 1]))

    assert counters.cycles == 7 + CLOSED_BANK + 7 + 1


def test_a_missing_line_is_fetched_for_a_write_that_goes_through(simulate):
    counters = simulate(cached(THROUGH), work([store(A), load(A), LONG]))

    assert (counters.cache_hits[0], counters.cache_misses[0], counters.cache_fetches[0]) == (1, 1, 1)
    assert counters.dram_writes.tolist() == [1]


@pytest.mark.parametrize("policy", WritePolicy)
def test_without_allocation_a_write_passes_on(simulate, policy):
    """It takes the hit time and leaves no line: the load misses."""
    cache = CACHE._replace(write_policy=policy, allocates_writes=0, hit_cycles=5)
    counters = simulate(cached(cache), work([store(A), 1]))

    assert counters.cycles == 5 + 1
    assert counters.cache_misses.tolist() == [1]
    assert (counters.cache_fetches[0], counters.cache_writethroughs_out[0]) == (0, 1)
    assert simulate(cached(cache), work([store(A), load(A)])).cache_misses.tolist() == [2]


def test_without_allocation_a_write_still_hits(simulate):
    counters = simulate(
        cached(ONE_LINE._replace(allocates_writes=0)), work([load(A), store(A), load(B), LONG])
    )

    assert (
        counters.cache_hits[0],
        counters.cache_writethroughs_out[0],
        counters.cache_writebacks_out[0],
    ) == (1, 0, 1)


def test_a_write_of_the_whole_line_is_not_fetched(simulate):
    counters = simulate(cached(CACHE._replace(hit_cycles=3)), work([store(A, 8), load(A), 1]))

    assert counters.cycles == 3 + 3 + 1
    assert (counters.cache_misses[0], counters.cache_fetches[0]) == (1, 0)


def test_sectors_are_fetched_by_themselves(simulate):
    """The line's second sector misses again, its first hits; a fetch is one sector."""
    counters = simulate(cached(SECTORED), work([load(0), load(8), load(4)]))

    assert (counters.cache_misses[0], counters.cache_hits[0], counters.cache_fetches[0]) == (2, 1, 2)
    assert counters.cache_fetched_bytes.tolist() == [16]
    assert counters.dram_data_clocks.tolist() == [2]


def test_two_sectors_of_a_line_can_be_on_their_way(simulate):
    """Sector 1 is asked for in cycle 1, its burst follows that of sector 0."""
    spec = machine(num_threads=3, caches=(SECTORED,))
    counters = simulate(spec, work([load(0)], [load(8)], [load(12)]))

    assert counters.cycles == 1 + CLOSED_BANK + 2
    assert (counters.cache_misses[0], counters.cache_merges[0]) == (2, 1)


def test_a_request_across_sectors_of_two_fetches_waits_for_one(simulate):
    """Threads 0 and 1 fetch sectors 0 and 1; thread 2 wants both and is accepted when sector 0 is here: a merge."""
    spec = machine(num_threads=3, caches=(SECTORED,))
    counters = simulate(spec, work([load(0)], [load(8)], [load(4, 8)]))

    assert counters.cache_blocked.tolist() == [24]
    assert (counters.cache_merges[0], counters.cache_hits[0]) == (1, 0)


def test_dirty_sectors_are_written_back_in_runs(simulate):
    """Sectors 0, 2 and 3 are dirty: two writes, of 16 and of 8 bytes."""
    cache = SECTORED._replace(num_sets=1, num_ways=1)
    counters = simulate(cached(cache), work([store(0), store(16), store(24), load(32), LONG]))

    assert counters.cache_writebacks_out.tolist() == [2]
    assert counters.cache_written_bytes.tolist() == [24]
    assert counters.dram_writes.tolist() == [2]


def test_a_sector_that_is_written_without_allocation_is_here(simulate):
    """As in Dinero IV: the line is, so the write stays, and its sector counts as present."""
    counters = simulate(
        cached(SECTORED._replace(allocates_writes=0)), work([load(0), store(8), load(8), LONG])
    )

    assert (counters.cache_misses[0], counters.cache_hits[0], counters.cache_fetches[0]) == (2, 1, 1)


@pytest.mark.parametrize(
    ("order", "misses"), [(VictimOrder.FETCH_FIRST, 3), (VictimOrder.WRITE_BACK_FIRST, 2)]
)
def test_the_next_level_sees_the_victim_before_or_after_the_fetch(simulate, order, misses):
    """One line each. A's write-back finds it in the L2 unless B has driven it out."""
    first = ONE_LINE._replace(victim_order=order)
    counters = simulate(cached(first, ONE_LINE), work([store(A), load(B), LONG]))

    assert counters.cache_misses.tolist() == [2, misses]


def test_a_line_longer_than_the_parents_is_fetched_in_parts(simulate):
    """The L2 looks both parts up in cycle 2, the DRAM has them in 7, and the second burst is here in 33."""
    first, second = CACHE._replace(hit_cycles=2, line_bytes=16), CACHE._replace(hit_cycles=5)
    counters = simulate(cached(first, second), work([load(A), load(A + 8)]))

    assert counters.cycles == 2 + 5 + CLOSED_BANK + 2 + 2
    assert counters.cache_fetches.tolist() == [2, 2]
    assert counters.cache_misses.tolist() == [1, 2]
    assert counters.cache_fetch_ticks.tolist() == [2 * (5 + CLOSED_BANK) + 2, 2 * CLOSED_BANK + 2]
    assert counters.dram_reads.tolist() == [2]


def test_a_victim_longer_than_the_parents_line_is_written_back_in_parts(simulate):
    first = CACHE._replace(line_bytes=16, num_sets=1, num_ways=1)
    counters = simulate(cached(first, CACHE), work([store(A), load(B), LONG]))

    assert counters.cache_writebacks_out.tolist() == [2, 0]
    assert counters.cache_writebacks_in.tolist() == [0, 2]


def test_the_wait_for_parts_is_where_the_part_is_that_comes_last(simulate):
    """The L2 has the second half of the line; the first half comes from the DRAM."""
    first, second = CACHE._replace(line_bytes=16, parent=2), CACHE
    spec = machine(num_cores=2, caches=(first, CACHE._replace(parent=2), second))._replace(core_cache=(0, 1))
    counters = simulate(spec, work([LONG, load(A), 1], [load(A + 8)]))

    assert counters.cache_hits[2] == 1
    assert stalls(counters) == {"0.lookup": 1, "2.lookup": 1, "dram.bus": 11}


CLEARED = CACHE._replace(clear=ClearSpec(8, 0, 64, 1), num_sets=1, num_ways=1, hit_cycles=3)


def test_what_is_known_to_be_cleared_is_not_fetched(simulate):
    """It takes the hit time. Driven out clean, it is still known to be cleared."""
    counters = simulate(cached(CLEARED), work([load(A), load(B), load(A), 1]))

    assert counters.cycles == 3 * 3 + 1
    assert (counters.cache_misses[0], counters.cache_clear_fills[0], counters.cache_fetches[0]) == (3, 3, 0)


def test_what_was_written_back_is_fetched(simulate):
    counters = simulate(cached(CLEARED), work([store(A), load(B), LONG, load(A)]))

    assert (counters.cache_clear_fills[0], counters.cache_fetches[0]) == (2, 1)


def test_what_has_no_bit_is_fetched(simulate):
    """The last block and the first byte behind it."""
    bits = ClearSpec(8, A, 2, 1)
    counters = simulate(cached(CLEARED._replace(clear=bits)), work([load(A + 8), load(A + 16)]))

    assert (counters.cache_clear_fills[0], counters.cache_fetches[0]) == (1, 1)


def test_a_line_of_several_blocks_needs_all_their_bits(simulate):
    """A write of one block of two: the line is fetched after it was written back."""
    cache = CLEARED._replace(line_bytes=16, allocates_writes=0)
    counters = simulate(cached(cache), work([store(0), load(0), load(16)]))

    assert (counters.cache_clear_fills[0], counters.cache_fetches[0]) == (1, 1)


def test_clear_sets_the_bits_of_whole_blocks(simulate):
    """Of bytes 4 to 27 those are 8 to 23: blocks 1 and 2."""
    cache = CLEARED._replace(clear=ClearSpec(8, 0, 64, 0))
    counters = simulate(cached(cache), work([clear(4, 24), load(0), load(8), load(16), load(24)]))

    assert counters.cache_clears.tolist() == [1]
    assert (counters.cache_clear_fills[0], counters.cache_fetches[0]) == (2, 2)


def test_clear_takes_the_hit_time_and_drops_lines(simulate):
    """The dirty line is gone without a write-back."""
    counters = simulate(cached(CLEARED), work([store(A), clear(0, 64), load(A), load(B), LONG]))

    assert counters.cycles == 4 * 3 + LONG
    assert counters.cache_writebacks_out.tolist() == [0]
    assert counters.cache_clear_fills.tolist() == [3]


def test_clear_without_clear_bits_is_refused(simulate):
    with pytest.raises(ArchsimError, match="CLEAR at address 0: the core's cache has no clear bits"):
        simulate(machine(), work([clear(0, 64)]))


def test_a_full_write_queue_holds_up_the_next_write(simulate):
    """A is looked up in cycle 0 and accepted by the L2 in 4; B, looked up in 4, has to wait until 5."""
    first = THROUGH._replace(num_write_entries=1, hit_cycles=4, allocates_writes=0)
    counters = simulate(cached(first, CACHE), work([store(A), store(B), 1]))

    assert counters.cache_blocked.tolist() == [1, 0]
    assert counters.cycles == 5 + 4 + 1


def test_the_dram_takes_a_write_when_it_arrives(simulate):
    """B is looked up in 4; A arrives at the DRAM in that very cycle."""
    first = THROUGH._replace(num_write_entries=1, hit_cycles=4, allocates_writes=0)
    counters = simulate(cached(first), work([store(A), store(B), 1]))

    assert counters.cache_blocked.tolist() == [0]
    assert counters.cycles == 4 + 4 + 1


@pytest.mark.parametrize(
    ("arbiter", "answer"), [(Arbiter.ARRIVAL, 47), (Arbiter.FIXED_PRIORITY, 49), (Arbiter.ROUND_ROBIN, 43)]
)
def test_the_arbiter_chooses_among_those_that_have_arrived(simulate, arbiter, answer):
    """One port. Four threads of core 0 and of core 1 ask in cycles 40 to 43, core 2 in 42.

    By arrival six are served before core 2, by priority eight, in turn two.
    """
    spec = machine(num_cores=3, num_threads=4, caches=(CACHE._replace(num_ports=1, arbiter=arbiter),))
    counters = simulate(spec, work(*[[10, load(A)]] * 8, [load(A), 16, load(A), 100]))

    assert counters.cache_hits.tolist() == [9]
    assert counters.cycles == answer + 100
