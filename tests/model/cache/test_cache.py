"""What a lookup finds, what it needs, what leaves the cache, and when the answer is here.

One tick is a core cycle and a memory clock. A fetch that reaches the DRAM at T is here at T + 25 while its bank is
closed (CLOSED_BANK), at T + 12 when its row is open (OPEN_ROW); the lines used here are of one row.
"""

import pytest

from tests.machine.build import (
    CACHE,
    CLOSED_BANK,
    OPEN_ROW,
    address,
    both_models,
    cached,
    load,
    machine,
    stalls,
    store,
    work,
)

pytestmark = both_models

A, B, C, D = (address(column=column) for column in (0, 2, 4, 6))
ONE_LINE = CACHE._replace(num_sets=1, num_ways=1)
TWO_LINES = CACHE._replace(num_sets=1, num_ways=2)
LONG = 300  # cycles in which everything that is on its way arrives


def test_a_hit_takes_hit_cycles(simulate):
    first = 7 + CLOSED_BANK
    counters = simulate(cached(CACHE._replace(hit_cycles=7)), work([load(A), load(A), 1]))

    assert counters.cycles == first + 7 + 1
    assert counters.cache_hits.tolist() == [1]
    assert counters.cache_misses.tolist() == [1]
    assert counters.cache_reads.tolist() == [2]


def test_hit_cycles_are_core_cycles(simulate):
    spec = cached(CACHE._replace(hit_cycles=7))
    spec = spec._replace(core=spec.core._replace(period_ticks=5))

    # The fetch arrives at tick 35 and its line at tick 60, cycle 12.
    assert simulate(spec, work([load(A), load(A), 1])).cycles == 12 + 7 + 1


def test_a_miss_pays_every_level_it_passes(simulate):
    """L1 looks up at 0, L2 at 2, the DRAM has the fetch at 7, and the line, two bursts, at 34."""
    first, second = CACHE._replace(hit_cycles=2), CACHE._replace(hit_cycles=5, line_bytes=16)
    counters = simulate(cached(first, second), work([load(A)]))

    assert counters.cycles == 2 + 5 + CLOSED_BANK + 2
    assert counters.cache_fetch_ticks.tolist() == [5 + CLOSED_BANK + 2, CLOSED_BANK + 2]


def test_a_hit_in_the_second_level_takes_both_hit_times(simulate):
    """The other half of the L2's line."""
    first, second = CACHE._replace(hit_cycles=2), CACHE._replace(hit_cycles=5, line_bytes=16)
    counters = simulate(cached(first, second), work([load(A), load(A + 8), 1]))

    assert counters.cycles == (2 + 5 + CLOSED_BANK + 2) + (2 + 5) + 1
    assert counters.cache_hits.tolist() == [0, 1]
    assert stalls(counters) == {"0.lookup": 2 + 2, "1.lookup": 5 + 4, "dram.activation": 13, "dram.bus": 13}


def test_a_second_miss_of_a_line_merges(simulate):
    counters = simulate(machine(num_threads=2), work([load(A), 1], [load(A), 1]))

    assert counters.cycles == 1 + CLOSED_BANK + 2
    assert counters.cache_merges.tolist() == [1]
    assert counters.cache_fetches.tolist() == [1]


def test_a_merge_waits_for_what_the_fetch_waits_for_that_it_joined(simulate):
    """Core 1 merges in the L2 with the fetch of core 0: both wait for the DRAM."""
    first, second = CACHE._replace(parent=2), CACHE
    spec = machine(num_cores=2, caches=(first, first, second))._replace(core_cache=(0, 1))
    counters = simulate(spec, work([load(A), 1], [load(A), 1]))

    assert counters.cache_merges.tolist() == [0, 0, 1]
    rest = {"2.lookup": 1, "dram.activation": 13, "dram.bus": 11}
    assert stalls(counters, 0) == {"0.lookup": 1, **rest}
    assert stalls(counters, 1) == {"1.lookup": 1, **rest}


def test_without_a_free_mshr_a_miss_waits(simulate):
    """B, looked up in cycle 1, is accepted in cycle 26, when A has come."""
    spec = machine(num_threads=2, caches=(CACHE._replace(num_mshrs=1),))
    counters = simulate(spec, work([load(A)], [load(B)]))

    assert counters.cycles == 26 + 1 + OPEN_ROW
    assert counters.cache_blocked.tolist() == [25]


def test_with_two_mshrs_it_does_not(simulate):
    """Both wait for the activation; B is read n_ccd after A."""
    spec = machine(num_threads=2, caches=(CACHE._replace(num_mshrs=2),))
    counters = simulate(spec, work([load(A)], [load(B)]))

    assert counters.cycles == 1 + CLOSED_BANK + 2
    assert counters.cache_blocked.tolist() == [0]


def test_without_a_free_target_a_merge_waits(simulate):
    """The line is here in cycle 26; then it is a hit."""
    spec = machine(num_threads=3, caches=(CACHE._replace(num_targets=2),))
    counters = simulate(spec, work([load(A)], [load(A)], [load(A)]))

    assert counters.cycles == 26 + 1
    assert counters.cache_blocked.tolist() == [24]
    assert (counters.cache_merges[0], counters.cache_hits[0]) == (1, 1)


def test_a_request_that_cannot_be_accepted_blocks_those_behind_it(simulate):
    """Thread 2 could merge with A in cycle 2 but stands behind B."""
    spec = machine(num_threads=3, caches=(CACHE._replace(num_mshrs=1),))
    counters = simulate(spec, work([load(A)], [load(B)], [load(A)]))

    assert (counters.cache_merges[0], counters.cache_hits[0]) == (0, 1)
    assert counters.cache_blocked.tolist() == [25]


def test_without_a_way_a_miss_waits(simulate):
    """The only way of the set is on its way."""
    spec = machine(num_threads=2, caches=(ONE_LINE,))
    counters = simulate(spec, work([load(A)], [load(B)]))

    assert counters.cycles == 26 + 1 + OPEN_ROW
    assert counters.cache_blocked.tolist() == [25]


def test_ports_bound_the_lookups_of_a_cycle(simulate):
    """Both cores look up in cycle 36: with one port core 1 has its answer a cycle later. That is not `blocked`."""
    same = [load(A), 10, load(A)]
    one = simulate(machine(num_cores=2, caches=(CACHE._replace(num_ports=1),)), work(same, same))
    two = simulate(machine(num_cores=2, caches=(CACHE._replace(num_ports=2),)), work(same, same))

    assert (one.cycles, two.cycles) == (38, 37)
    assert (one.cache_blocked[0], two.cache_blocked[0]) == (0, 0)


def test_cores_are_looked_up_before_child_caches(simulate):
    """Core 0's fetch and core 1's LOAD reach cache 1 in cycle 41; its only port serves core 1 first."""
    caches = (CACHE._replace(parent=1), CACHE._replace(num_ports=1))
    spec = machine(num_cores=2, caches=caches)._replace(core_cache=(0, 1))
    counters = simulate(spec, work([40, load(A)], [load(A), 15, load(A), 1]))

    assert counters.cache_hits.tolist() == [0, 2]
    assert counters.cycles == 43


def test_the_least_recently_used_line_leaves(simulate):
    """A was used after B, so C replaces B."""
    counters = simulate(cached(TWO_LINES), work([load(A), load(B), load(A), load(C), load(A)]))

    assert (counters.cache_hits[0], counters.cache_misses[0]) == (2, 3)


def test_lines_of_different_sets_do_not_meet(simulate):
    """Line numbers 0 and 2: one set of two sets; 0 and 1: both sets."""
    two_sets = CACHE._replace(num_sets=2, num_ways=1)
    same_set = simulate(cached(two_sets), work([load(0), load(16), load(0)]))
    both_sets = simulate(cached(two_sets), work([load(0), load(8), load(0)]))

    assert (same_set.cache_hits[0], both_sets.cache_hits[0]) == (0, 1)


def test_a_merge_counts_as_use(simulate):
    """Thread 1 merges with A after B was asked for, so C replaces B and A is still there."""
    spec = machine(num_threads=2, caches=(TWO_LINES,))
    counters = simulate(spec, work([load(A), LONG, load(C), load(A)], [load(B)], [], [2 * LONG]))
    merged = simulate(spec, work([load(A), LONG, load(C), load(A)], [load(B), load(A)], [], [2 * LONG]))

    assert counters.cache_hits[0] == 0
    assert merged.cache_hits[0] == 2


def test_a_clean_victim_is_dropped(simulate):
    counters = simulate(cached(ONE_LINE), work([load(A), load(B), LONG]))

    assert counters.cache_writebacks_out.tolist() == [0]
    assert counters.dram_writes.tolist() == [0]


@pytest.mark.parametrize("make_dirty", [[store(A)], [load(A), store(A)]], ids=["miss", "hit"])
def test_a_stored_line_is_written_back(simulate, make_dirty):
    counters = simulate(cached(ONE_LINE), work([*make_dirty, load(B), load(C), LONG]))

    assert counters.cache_writebacks_out.tolist() == [1]
    assert counters.dram_writes.tolist() == [1]
    assert counters.cache_writes.tolist() == [1]


def test_a_store_that_merges_makes_the_line_dirty(simulate):
    spec = machine(num_threads=2, caches=(ONE_LINE,))
    counters = simulate(spec, work([load(A)], [store(A), load(B), LONG]))

    assert counters.cache_merges.tolist() == [1]
    assert counters.cache_writebacks_out.tolist() == [1]


def test_a_line_that_comes_back_is_clean(simulate):
    counters = simulate(cached(ONE_LINE), work([store(A), load(B), load(A), load(B), LONG]))

    assert counters.cache_writebacks_out.tolist() == [1]


def test_a_write_back_that_hits_makes_the_parents_line_dirty(simulate):
    """L2 has both lines until C drives A out."""
    counters = simulate(cached(ONE_LINE, TWO_LINES), work([store(A), load(B), LONG, load(B), load(C), LONG]))

    assert counters.cache_writebacks_in.tolist() == [0, 1]
    assert counters.cache_writebacks_out.tolist() == [1, 0]

    counters = simulate(cached(ONE_LINE, TWO_LINES), work([store(A), load(B), load(C), load(D), LONG]))

    assert counters.cache_writebacks_out.tolist() == [1, 1]
    assert counters.dram_writes.tolist() == [1]


def test_a_whole_line_write_back_is_not_fetched(simulate):
    """L2 (one line) has C on its way when A comes back from L1: it waits for the way, then A is there at once."""
    counters = simulate(cached(TWO_LINES, ONE_LINE), work([store(A), load(B), load(C), LONG, load(A), 1]))

    assert counters.cache_fetches.tolist() == [4, 3]
    assert counters.cache_misses.tolist() == [4, 4]
    assert counters.cache_hits.tolist() == [0, 1]
    assert counters.cache_blocked.tolist() == [0, 1 + OPEN_ROW]


def test_a_whole_line_write_back_needs_no_mshr(simulate):
    """While core 1's miss holds the only MSHR of the L2, A is written back into it."""
    first, second = TWO_LINES._replace(parent=2), CACHE._replace(num_sets=1, num_ways=2, num_mshrs=1)
    spec = machine(num_cores=2, caches=(first, first, second))._replace(core_cache=(0, 1))
    counters = simulate(spec, work([store(A), load(B), load(C), LONG], [LONG, 1]))

    assert counters.cache_misses[2] == 4
    assert counters.cache_blocked.tolist() == [0, 0, 0]


def test_a_part_of_a_line_is_fetched_before_it_is_written(simulate):
    """The L2's lines are twice the L1's: A's write-back misses and fetches; the line is dirty when B drives it out."""
    wide = ONE_LINE._replace(line_bytes=16)
    steps = [store(A), load(B), load(C), LONG, load(D), LONG]
    counters = simulate(cached(TWO_LINES, wide), work(steps))

    assert counters.cache_writebacks_in.tolist() == [0, 1]
    assert counters.cache_fetches.tolist() == [4, 5]
    assert counters.cache_writebacks_out.tolist() == [1, 1]


def test_a_write_back_takes_no_target(simulate):
    """The L2's line is on its way for A's write-back; one target is free for the L1's fetch of A."""
    wide = ONE_LINE._replace(line_bytes=16, num_targets=1)
    steps = [store(A), load(B), load(C), load(A), 1]
    counters = simulate(cached(TWO_LINES, wide), work(steps))

    assert counters.cache_merges.tolist() == [0, 1]
