"""Both models return equal counters on random machines and random work."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from archsim.machine import compiled, reference
from archsim.trace.records import Tasks
from archsim.trace.stream import chunked, whole
from tests.machine.build import difference
from tests.machine.strategies import few_tasks, many_tasks, plays

quick = settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def cut(tasks: Tasks, sizes: list[int]):
    """The same tasks in chunks of the given numbers of tasks (the last takes what is left)."""
    first = 0
    for size in [*sizes, tasks.num_tasks]:
        last = min(first + size, tasks.num_tasks)
        low, high = tasks.starts[first], tasks.starts[last]
        yield Tasks(tasks.starts[first : last + 1] - low, tasks.records[low:high])
        first = last


def assert_equal_counters(played):
    spec, tasks = played
    believed = reference.simulate(spec, whole(tasks))
    used = compiled.simulate(spec, whole(tasks))

    assert not difference(used, believed), difference(used, believed)


@settings(quick, max_examples=100)
@given(plays(few_tasks()))
def test_both_models_agree_on_small_work(played):
    assert_equal_counters(played)


@settings(quick, max_examples=2000)
@given(plays(many_tasks()))
def test_both_models_agree_on_dense_work(played):
    assert_equal_counters(played)


@settings(quick, max_examples=300)
@given(plays(many_tasks()))
def test_both_models_flush_alike(played):
    spec, tasks = played
    used, believed = (model.simulate(spec, whole(tasks), flush=True) for model in (compiled, reference))

    assert not difference(used, believed), difference(used, believed)
    written_back = used.cache_writebacks_out.sum() >= believed.cache_writebacks_in.sum()
    assert written_back or used.cache_writethroughs_out.sum() > 0


@settings(quick, max_examples=60)
@given(plays(many_tasks()), st.sampled_from([8, 31, 32, 33, 65]), st.sampled_from([1, 5, 40]))
def test_both_models_agree_on_many_threads_that_compute(played, num_threads, longer):
    """More threads than a word of a set holds, and more turns than one between two operations."""
    spec, tasks = played
    records = tasks.records.copy()
    records["compute"] *= longer
    core = spec.core._replace(num_threads=num_threads)
    assert_equal_counters((spec._replace(core=core), tasks._replace(records=records)))


@pytest.mark.slow
@settings(quick, max_examples=5000)
@given(plays(many_tasks()))
def test_both_models_agree_on_much_work(played):
    assert_equal_counters(played)


@quick
@given(plays(many_tasks()), st.lists(st.integers(0, 5), max_size=5))
def test_chunks_do_not_matter(played, sizes):
    spec, tasks = played
    for simulate in (reference.simulate, compiled.simulate):
        in_one = simulate(spec, whole(tasks))
        in_many = simulate(spec, chunked(tasks.num_tasks, cut(tasks, sizes)))

        assert not difference(in_many, in_one), difference(in_many, in_one)


@quick
@given(plays(many_tasks()))
def test_the_same_run_gives_the_same_counters(played):
    spec, tasks = played
    for simulate in (reference.simulate, compiled.simulate):
        first, second = (simulate(spec, whole(tasks)) for _ in range(2))

        assert not difference(first, second), difference(first, second)
