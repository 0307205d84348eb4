"""Both models of a DRAM alone serve every stream alike, command by command."""

import itertools

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from archsim.machine.dram_alone import compiled, reference
from archsim.machine.dram_alone.stream import Requests
from archsim.model.dram.commands import COMMAND
from tests.machine.dram_alone.machines import preset, random_stream, spec_of
from tests.machine.strategies import drams

REQUEST_BYTES = 32


@st.composite
def streams(draw):
    """Requests near each other, in bursts and alone."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    count, footprint = draw(st.integers(0, 60)), draw(st.sampled_from([2, 8, 64]))
    addresses = rng.integers(0, footprint, count) * REQUEST_BYTES
    gaps = rng.integers(0, draw(st.sampled_from([1, 3, 40])), count)
    is_write = rng.random(count) < draw(st.sampled_from([0.0, 0.3, 0.7]))
    return Requests(addresses, is_write, np.cumsum(gaps))


def cut(stream, sizes=()):
    cuts = [0, *np.cumsum(sizes).tolist(), len(stream.addresses)]
    return [Requests(*(column[a:b] for column in stream)) for a, b in itertools.pairwise(cuts)]


def served(model, spec, stream, sizes=()):
    recorded = [np.zeros(0, COMMAND)]
    run = model.simulate(spec, REQUEST_BYTES, cut(stream, sizes), recorded.append)
    commands = np.concatenate(recorded)
    assert np.all(np.diff(commands["clock"]) >= 0)
    return run, commands[np.lexsort((commands["channel"], commands["clock"]))]


def assert_alike(used, believed):
    for name, value in believed._asdict().items():
        assert np.array_equal(getattr(used, name), value) if name != "counters" else True, name
    for name, value in believed.counters.items():
        assert np.array_equal(used.counters[name], value), name


@settings(max_examples=1000, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.sampled_from([1, 3]).flatmap(lambda ticks: drams(ticks, REQUEST_BYTES)), streams())
def test_both_models_serve_a_stream_alike(spec, stream):
    believed, wanted = served(reference, spec, stream)
    sizes = (len(stream.addresses) // 3,)
    used, found = served(compiled, spec, stream, sizes)

    assert found.tolist() == wanted.tolist()
    assert_alike(used, believed)
    assert_alike(compiled.simulate(spec, REQUEST_BYTES, cut(stream, sizes)), believed)  # channel by channel


def test_both_models_wait_alike_for_a_row_that_takes_thousands_of_clocks():
    dram = preset(
        "gddr3_700", "timing.n_rp=4500", "timing.n_rc=4518", "timing.n_refi=0", "max_wait_clocks=100000"
    )
    spec, stream = spec_of(dram, REQUEST_BYTES), random_stream(dram, 60, seed=1, line_bytes=REQUEST_BYTES)

    assert served(compiled, spec, stream)[1].tolist() == served(reference, spec, stream)[1].tolist()
