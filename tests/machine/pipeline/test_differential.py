"""Both models of a pipeline agree in every counter, whatever the machine and the work."""

from hypothesis import HealthCheck, given, settings

from archsim.machine.pipeline import compiled, reference
from tests.machine.pipeline.build import chunks, difference
from tests.machine.pipeline.strategies import cases

thorough = settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)


def played(simulate, case):
    names = tuple("abcdefgh"[: len(case.spec.units)])
    listed = case.chunks or (tuple([] for _ in names),)
    return simulate(case.spec, chunks(*listed))


@thorough
@given(cases())
def test_both_models_return_equal_counters(case):
    believed, used = (played(model.simulate, case) for model in (reference, compiled))

    assert not difference(used, believed), difference(used, believed)
