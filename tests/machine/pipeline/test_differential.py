"""Both models of a pipeline agree in every counter, whatever the machine and the work."""

import pytest
from hypothesis import HealthCheck, Phase, find, given, settings
from hypothesis import strategies as st

from archsim.machine.pipeline import compiled, reference
from archsim.machine.watch import Watch
from tests.machine.pipeline.build import chunks, difference
from tests.machine.pipeline.strategies import cases

thorough = settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)

quick = settings(thorough, max_examples=40)


def played(simulate, case):
    names = tuple("abcdefgh"[: len(case.spec.units)])
    listed = case.chunks or (tuple([] for _ in names),)
    return simulate(case.spec, chunks(*listed))


@thorough
@given(cases())
def test_both_models_return_equal_counters(case):
    believed, used = (played(model.simulate, case) for model in (reference, compiled))

    assert not difference(used, believed), difference(used, believed)


def heard(model, case, place, flush):
    """Counters, requests told at a place, and commands of the DRAM."""
    told, commands = [], []
    watch = Watch((min(place, len(case.spec.caches)),), lambda chunk: told.extend(chunk.tolist()))

    def simulate(spec, work):
        return model.simulate(
            spec, work, sink=lambda some: commands.extend(some.tolist()), watch=watch, flush=flush
        )

    return played(simulate, case), sorted(told), sorted(commands)


@quick
@given(cases(), st.integers(0, 3), st.booleans())
def test_both_models_tell_the_same_requests_and_commands_and_flush_alike(case, place, flush):
    (believed, wanted, issued), (used, told, recorded) = (
        heard(model, case, place, flush) for model in (reference, compiled)
    )

    assert not difference(used, believed), difference(used, believed)
    assert told == wanted
    assert recorded == issued
    if place == 3:
        memory = used.memory
        assert len(told) == (memory.dram_reads + memory.dram_writes + memory.dram_forwarded).sum()


def joined(case):
    """The case's work in a single chunk."""
    units = zip(*case.chunks, strict=True)
    return case._replace(chunks=(tuple([task for tasks in unit for task in tasks] for unit in units),))


@quick
@given(cases())
def test_how_the_work_is_cut_makes_no_difference(case):
    if case.chunks:
        in_many, in_one = (played(compiled.simulate, each) for each in (case, joined(case)))

        assert not difference(in_many, in_one), difference(in_many, in_one)


@quick
@given(cases())
def test_the_same_run_gives_the_same_counters(case):
    first, second = (played(compiled.simulate, case) for _ in range(2))

    assert not difference(first, second), difference(first, second)


FAULTS = {
    "latency": lambda unit: unit._replace(latency_cycles=unit.latency_cycles + 1),
    "interval": lambda unit: unit._replace(interval_cycles=unit.interval_cycles + 1),
    "outstanding": lambda unit: unit._replace(outstanding=unit.outstanding + 1),
    "in_flight": lambda unit: unit._replace(in_flight=unit.in_flight + 1),
    "lanes": lambda unit: unit._replace(lanes=unit.lanes + 1),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_random_cases_notice_a_fault(fault):
    """Some case gives other counters as soon as one of the models has a unit with another number."""

    def is_noticed(case):
        wrong = case.spec._replace(units=tuple(FAULTS[fault](unit) for unit in case.spec.units))
        right, faulty = (played(compiled.simulate, case._replace(spec=spec)) for spec in (case.spec, wrong))
        return bool(difference(faulty, right))

    assert find(cases(), is_noticed, settings=settings(quick, max_examples=500, phases=[Phase.generate]))
