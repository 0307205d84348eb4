"""What a pipeline tells at regular intervals: the same by both models, without changing anything, and adding up."""

from functools import partial
from itertools import pairwise

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from archsim.machine.pipeline import compiled, reference
from archsim.machine.pipeline.series import pipeline_sample
from archsim.machine.series import Sampling
from tests.machine.pipeline.build import UNIT, both_models, chain, delayed, difference, emit, mark, take, work
from tests.machine.pipeline.strategies import cases
from tests.machine.pipeline.test_differential import played
from tests.machine.test_series import plain, told

END = 1 << 40


@settings(max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(cases(), st.integers(1, 60), st.booleans())
def test_both_models_tell_the_same_and_play_as_if_they_did_not(case, interval, flush):
    counters, samples = [], []
    for model in (reference, compiled):
        samples.append([])
        sampling = Sampling(interval, samples[-1].append)
        counters.append(played(partial(model.simulate, flush=flush, sampling=sampling), case))
    untold = played(partial(compiled.simulate, flush=flush), case)

    assert [plain(sample) for sample in samples[1]] == [plain(sample) for sample in samples[0]]
    for other in (counters[1], untold):
        assert not difference(other, counters[0]), difference(other, counters[0])
    whole = [*samples[1], pipeline_sample(END, untold)]
    for before, after in pairwise(whole):
        assert all(np.all(np.asarray(a) <= np.asarray(b)) for a, b in zip(before, after, strict=True))


@both_models
def test_a_sample_says_what_happened_before_its_cycle(simulate):
    """An item is put into the first fifo in 5 and taken in 6, put into the second one in 9 and taken in 10."""
    a, b = UNIT._replace(latency_cycles=5), UNIT._replace(latency_cycles=3)
    done = work([[emit()]], [[take(), emit()]], [[take()]])
    _, samples = told(simulate, chain(a, b, UNIT), done, 2)

    seen = [(s.cycle, s.busy.tolist(), s.stayed.tolist()) for s in samples]
    assert seen[2:] == [(6, [1, 0, 0], [1, 0]), (8, [1, 1, 0], [1, 0]), (10, [1, 1, 0], [1, 1])]


@both_models
def test_a_delay_stream_is_told_in_bytes(simulate):
    """Items of 5 and 3 bytes are emitted in 0 and 1, put in in 1 and 2, and stay until they are read back."""
    done = work([[emit(0, 5)], [emit(0, 3), mark()]], [[take()], [take()]])
    _, samples = told(simulate, delayed(UNIT, UNIT), done, 10)

    assert [(s.cycle, s.stayed.tolist()) for s in samples[:2]] == [
        (10, [5 * 9 + 3 * 8]),
        (20, [5 * 19 + 3 * 18]),
    ]
    assert samples[0].data_clocks == 0
    assert samples[1].data_clocks == 1  # the line is written
