"""Nothing is lost and nothing appears: laws that hold for the counters of every run.

The compiled model is asked; test_differential.py says that the reference model counts the same.
"""

import numpy as np
from hypothesis import HealthCheck, given, settings

from archsim.machine import compiled
from archsim.machine.counters import STALL_LOCK, STALL_NO_WORK
from archsim.model.cache.spec import DRAM_PARENT
from archsim.trace.records import Op, num_instructions
from archsim.trace.stream import whole
from tests.machine.strategies import many_tasks, plays

quick = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))

runs = given(plays(many_tasks()))


@quick
@runs
def test_every_issue_slot_is_useful_or_charged(played):
    spec, tasks = played
    counters = compiled.simulate(spec, whole(tasks))

    assert np.all(counters.stalled >= 0)
    assert np.all(counters.useful + counters.stalled.sum(axis=1) == counters.cycles)


@quick
@runs
def test_all_of_the_work_is_done(played):
    spec, tasks = played
    ops = tasks.records["op"].tolist()
    counters = compiled.simulate(spec, whole(tasks))

    assert counters.tasks.sum() == tasks.num_tasks
    assert counters.useful.sum() == num_instructions(tasks)
    assert counters.emitted.sum() == ops.count(Op.EMIT)
    assert counters.locks_taken == ops.count(Op.LOCK)
    assert counters.locks_waited <= counters.locks_taken


@quick
@runs
def test_lookups_are_accesses_and_fetches(played):
    spec, tasks = played
    ops = tasks.records["op"].tolist()
    is_child = np.array([cache.parent != DRAM_PARENT for cache in spec.caches])
    counters = compiled.simulate(spec, whole(tasks))

    assert counters.cache_reads.sum() == ops.count(Op.LOAD) + counters.cache_fetches[is_child].sum()
    assert counters.cache_writes.sum() == ops.count(Op.STORE)
    assert counters.cache_clears.sum() == ops.count(Op.CLEAR)


@quick
@runs
def test_a_lookup_hits_merges_or_misses(played):
    spec, tasks = played
    counters = compiled.simulate(spec, whole(tasks))

    accepted = counters.cache_reads + counters.cache_writes + counters.cache_writebacks_in
    found = counters.cache_hits + counters.cache_merges + counters.cache_misses
    assert np.array_equal(accepted, found)
    assert np.all(counters.cache_clear_fills <= counters.cache_misses)


@quick
@runs
def test_what_leaves_a_level_arrives_at_the_next(played):
    spec, tasks = played
    parents = np.array([cache.parent for cache in spec.caches])
    counters = compiled.simulate(spec, whole(tasks))
    writes_out = counters.cache_writebacks_out + counters.cache_writethroughs_out

    for parent in sorted(set(parents[parents != DRAM_PARENT].tolist())):
        if parent not in spec.core_cache:
            assert counters.cache_fetches[parents == parent].sum() == counters.cache_reads[parent]
        assert writes_out[parents == parent].sum() == counters.cache_writebacks_in[parent]
    last = parents == DRAM_PARENT
    assert counters.cache_fetches[last].sum() == counters.dram_reads.sum() + counters.dram_forwarded.sum()
    assert writes_out[last].sum() == counters.dram_writes.sum()


@quick
@runs
def test_dram_requests_are_classified_once_and_served_once(played):
    spec, tasks = played
    counters = compiled.simulate(spec, whole(tasks))

    served = counters.dram_reads + counters.dram_writes
    considered = counters.dram_row_hits + counters.dram_row_misses + counters.dram_row_conflicts
    assert np.array_equal(served, considered)
    last = np.array([cache.parent == DRAM_PARENT for cache in spec.caches])
    sent = (counters.cache_fetched_bytes + counters.cache_written_bytes)[last].sum()
    sent -= counters.dram_forwarded_bytes.sum()
    assert counters.dram_data_clocks.sum() * spec.dram.clock_beats * spec.dram.beat_bytes == sent


@quick
@runs
def test_banks_are_opened_before_they_are_closed(played):
    """A precharge-all counts once though it closes up to all banks."""
    spec, tasks = played
    banks = spec.dram.num_banks
    counters = compiled.simulate(spec, whole(tasks))

    closed_at_most = counters.dram_precharges + counters.dram_refreshes * (banks - 1)
    assert np.all(counters.dram_precharges <= counters.dram_activates)
    assert np.all(counters.dram_activates <= closed_at_most + banks)


@quick
@runs
def test_who_never_waits_for_a_lock_is_not_charged_for_one(played):
    spec, tasks = played
    counters = compiled.simulate(spec, whole(tasks))

    if counters.locks_waited == 0:
        assert counters.lock_wait_ticks == 0
        assert counters.stalled[:, STALL_LOCK].sum() == 0
    if tasks.num_tasks == 0:
        assert counters.stalled[:, STALL_NO_WORK].sum() == 0
