"""What is told at regular intervals: the same by both models, without changing anything, and adding up."""

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from archsim.machine import compiled, reference
from archsim.machine.series import Sampling, sample_of
from archsim.trace.stream import whole
from tests.machine.build import CLOSED_BANK, address, both_models, difference, load, machine, work
from tests.machine.strategies import many_tasks, plays


def told(simulate, spec, work, interval):
    samples = []
    counters = simulate(spec, work, sampling=Sampling(interval, samples.append))
    return counters, samples


def plain(sample):
    return [np.asarray(field).tolist() for field in sample]


@settings(max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(plays(many_tasks()), st.integers(1, 60))
def test_both_models_tell_the_same_and_play_as_if_they_did_not(played, interval):
    spec, tasks = played
    believed, expected = told(reference.simulate, spec, whole(tasks), interval)
    used, found = told(compiled.simulate, spec, whole(tasks), interval)

    assert [plain(sample) for sample in found] == [plain(sample) for sample in expected]
    assert not difference(used, believed), difference(used, believed)
    untold = compiled.simulate(spec, whole(tasks))
    assert not difference(used, untold), difference(used, untold)
    for before, after in zip(found, [*found[1:], sample_of(1 << 40, used)], strict=True):
        assert all(np.all(np.asarray(a) <= np.asarray(b)) for a, b in zip(before, after, strict=True))


@both_models
def test_a_sample_says_what_happened_before_its_cycle(simulate):
    """The LOAD is issued and looked up in 0, its column command is in 1 + n_rcd_read = 14, the next issue in 26."""
    _, samples = told(simulate, machine(), work([load(address()), 20]), 14)

    seen = [
        (s.cycle, int(s.busy[0]), int(s.lookups[0]), s.classified, s.data_clocks, s.waited_clocks)
        for s in samples
    ]
    first = 1 + CLOSED_BANK
    assert seen == [(14, 1, 1, 1, 0, 0), (28, 1 + 28 - first, 1, 1, 1, 13), (42, 1 + 42 - first, 1, 1, 1, 13)]
