"""How long requests are under way at each level, by hand, on both models, and the classes that they are counted in."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from archsim.model.latency import NUM_CLASSES, class_of, shortest
from tests.machine.build import (
    CACHE,
    CLOSED_BANK,
    OPEN_ROW,
    address,
    both_models,
    cached,
    load,
    machine,
    store,
    work,
)

A, B = address(), address(column=2)


def found(counters):
    """(level, shortest latency of the class) -> requests."""
    levels, classes = np.nonzero(counters.latencies)
    return {
        (int(level), shortest(int(number))): int(counters.latencies[level, number])
        for level, number in zip(levels, classes, strict=True)
    }


def rounded(cycles):
    return shortest(class_of(cycles))


@given(st.integers(0, 1 << 30))
def test_a_class_holds_what_it_says(cycles):
    number = class_of(cycles)

    assert shortest(number) <= cycles < shortest(number + 1)
    assert cycles < 8 or shortest(number + 1) - shortest(number) <= cycles / 4


def test_the_last_class_holds_all_that_is_longer():
    assert class_of(1 << 60) == NUM_CLASSES - 1


@both_models
def test_a_miss_and_a_hit_take_what_they_take(simulate):
    caches = CACHE._replace(hit_cycles=2), CACHE._replace(hit_cycles=5)
    counters = simulate(cached(*caches), work([load(A), load(A), 1]))

    miss = 2 + 5 + CLOSED_BANK
    assert found(counters) == {
        (0, 2): 1,
        (0, rounded(miss)): 1,
        (1, rounded(miss - 2)): 1,
        (2, rounded(CLOSED_BANK)): 1,
    }


@both_models
def test_a_wait_for_a_port_and_a_merge_count(simulate):
    """Core 1's LOADs are looked up a cycle later: the first merges, so its line comes with core 0's; the next hits."""
    steps = [load(A), 10, load(A), 1]
    counters = simulate(machine(num_cores=2, caches=(CACHE._replace(num_ports=1),)), work(steps, steps))

    assert found(counters) == {
        (0, 1): 1,
        (0, 2): 1,
        (0, rounded(1 + CLOSED_BANK)): 2,
        (1, rounded(CLOSED_BANK)): 1,
    }


@both_models
def test_a_wait_for_an_mshr_counts(simulate):
    """B is accepted 25 cycles after it came."""
    spec = machine(num_threads=2, caches=(CACHE._replace(num_mshrs=1),))
    counters = simulate(spec, work([load(A)], [load(B)]))

    assert found(counters) == {
        (0, rounded(1 + CLOSED_BANK)): 1,
        (0, rounded(25 + 1 + OPEN_ROW)): 1,
        (1, rounded(CLOSED_BANK)): 1,
        (1, rounded(OPEN_ROW)): 1,
    }


@both_models
def test_a_write_that_passes_on_is_answered_and_its_write_is_not(simulate):
    spec = cached(CACHE._replace(allocates_writes=0, hit_cycles=3))

    assert found(simulate(spec, work([store(A), 1]))) == {(0, 3): 1}
