"""Requests told at one place of a machine: what by hand, the same by both models, in order, all of them."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from archsim.machine import compiled, reference
from archsim.machine.watch import Watch
from archsim.model.cache import compiled_state as cache_model
from archsim.trace.accesses import Kind
from archsim.trace.stream import whole
from tests.machine.build import CACHE, cached, load, store, work
from tests.machine.strategies import many_tasks, plays


def told(model, spec, played, *places):
    chunks = []
    counters = model.simulate(spec, played, watch=Watch(places, chunks.append))
    return counters, [access for chunk in chunks for access in chunk.tolist()]


@pytest.mark.parametrize("model", [reference, compiled], ids=["reference", "compiled"])
def test_what_reaches_each_place(model):
    """A store and a load of two lines that share a set: the store's line is a victim of the load."""
    spec = cached(CACHE._replace(num_sets=1, num_ways=1, hit_cycles=2), CACHE)
    steps = [store(4), 5, load(64, 8)]

    (_, first), (_, second), (_, dram) = (told(model, spec, work(steps), place) for place in (0, 1, 2))

    assert [access[1:] for access in first] == [(4, 4, 0, Kind.WRITE), (64, 8, 0, Kind.READ)]
    assert [access[1:] for access in second] == [
        (0, 8, 0, Kind.READ),
        (64, 8, 0, Kind.READ),
        (0, 8, 0, Kind.WRITE),
    ]
    assert [access[1:] for access in dram] == [(0, 8, 1, Kind.READ), (64, 8, 1, Kind.READ)]
    assert first[0][0] == 0
    assert second[0][0] == 2  # the lookup's hit time after the store
    assert dram[0][0] == 3  # and that of the second cache


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(plays(many_tasks()), st.integers(0, 9), st.sampled_from([16, 1 << 16]))
def test_both_models_tell_the_same(play, place, seen_at_once):
    spec, tasks = play
    dram = len(spec.caches)
    places = [dram] if place % 4 == 3 else sorted({place % dram, place % 3 % dram})
    room = 4 * (spec.core.num_cores + cache_model.most_sent(spec.caches)) + seen_at_once
    before, cache_model.SEEN_AT_ONCE = cache_model.SEEN_AT_ONCE, room
    try:
        counted, found = told(compiled, spec, whole(tasks), *places)
    finally:
        cache_model.SEEN_AT_ONCE = before
    believed, wanted = told(reference, spec, whole(tasks), *places)

    assert sorted(found) == sorted(wanted)  # a thread and a cache may have one number: they may change places
    assert [access[0] for access in found] == sorted(access[0] for access in found)
    if places != [dram]:
        names = ("cache_reads", "cache_writes", "cache_writebacks_in")
        assert len(found) == sum(int(getattr(counted, name)[places].sum()) for name in names)
    plain = compiled.simulate(spec, whole(tasks))
    assert all(np.array_equal(a, b) for a, b in zip(plain, counted, strict=True))
    assert all(np.array_equal(a, b) for a, b in zip(believed, counted, strict=True))
