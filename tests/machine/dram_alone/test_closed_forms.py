"""What a DRAM alone does is what its timing says, in closed form: latency, bandwidth, the cost of refresh."""

from fractions import Fraction

import numpy as np
import pytest

from archsim.machine.dram_alone import compiled, reference
from archsim.machine.dram_alone.stream import Requests
from tests.machine.dram_alone.machines import COMMANDED, LINE_BYTES, preset, spec_of

both_models = pytest.mark.parametrize("model", [reference, compiled], ids=["reference", "compiled"])


def stream(addresses, arrivals=None, writes=False):
    addresses = np.asarray(addresses)
    nothing = np.zeros(len(addresses), np.int64)
    return Requests(
        addresses, nothing.astype(bool) | writes, nothing if arrivals is None else np.asarray(arrivals)
    )


def without_refresh(name, *overrides):
    return spec_of(preset(name, "timing.n_refi=0", *overrides))


def up(fraction):
    return -(-fraction.numerator // fraction.denominator)


def read_clocks(spec):
    """From the first RD of a line to its last beat."""
    bursts = LINE_BYTES // (spec.burst_beats * spec.beat_bytes)
    return (
        (bursts - 1) * spec.timing.n_ccd_l
        + spec.timing.n_cl
        + Fraction(spec.burst_beats - 1, spec.clock_beats)
    )


@both_models
@pytest.mark.parametrize("name", COMMANDED)
def test_unloaded_latencies(model, name):
    """A closed bank, its open row, and another row of the bank, each long after the one before."""
    spec = without_refresh(name)
    rows = [0, 0, 1 << spec.row.shift]
    run = model.simulate(spec, LINE_BYTES, [stream(rows, [0, 1000, 2000])])

    hit = read_clocks(spec)
    wanted = [hit, spec.timing.n_rcd_read + hit, spec.timing.n_rp + spec.timing.n_rcd_read + hit]
    assert np.flatnonzero(run.latencies).tolist() == [up(clocks) for clocks in wanted]
    assert run.latency_max == up(wanted[2])


@pytest.mark.parametrize("name", COMMANDED)
def test_a_row_is_streamed_at_the_rate_of_column_commands(name):
    """Lines of one row of one bank: a burst every n_ccd_l; the peak where that is the length of a burst."""
    spec = without_refresh(name)
    bursts = LINE_BYTES // (spec.burst_beats * spec.beat_bytes)
    lines = np.arange(1 << spec.line.bits) << spec.line.shift
    one, all_of_row = (
        compiled.simulate(spec, LINE_BYTES, [stream(lines[:count])]).clocks for count in (1, len(lines))
    )

    between_lines = (bursts - 1) * spec.timing.n_ccd_l + max(spec.timing.n_ccd, spec.timing.n_ccd_l)
    assert all_of_row - one == (len(lines) - 1) * between_lines


@pytest.mark.parametrize("name", COMMANDED)
def test_long_streams_reach_the_peak_where_groups_allow_it(name):
    """Neighbouring lines: rows are opened ahead, so that only the bus, or a group's n_ccd_l, limits."""
    spec = without_refresh(name)
    count = 20_000
    run = compiled.simulate(spec, LINE_BYTES, [stream(np.arange(count) * LINE_BYTES)])

    bursts = LINE_BYTES // (spec.burst_beats * spec.beat_bytes)
    line_clocks = (bursts - 1) * spec.timing.n_ccd_l + spec.timing.n_ccd
    least = count // spec.num_channels * line_clocks
    assert least <= run.clocks <= 1.08 * least


@both_models
def test_refresh_takes_its_share(model):
    """An open row is streamed; each refresh costs PRE, REF, ACT and the wait before the PRE."""
    spec = spec_of(preset("ddr4_3200"))
    timing, count = spec.timing, 8000
    lines = np.tile(np.arange(1 << spec.line.bits) << spec.line.shift, 1 + count >> spec.line.bits)[:count]
    never = model.simulate(spec._replace(timing=timing._replace(n_refi=0)), LINE_BYTES, [stream(lines)])
    often = model.simulate(spec, LINE_BYTES, [stream(lines)])

    refreshes = int(often.counters["refreshes"].sum())
    assert refreshes == often.clocks // timing.n_refi > 5
    least = timing.n_rp + timing.n_rfc + timing.n_rcd_read
    assert least <= (often.clocks - never.clocks) / refreshes <= least + timing.n_rtp + timing.n_ccd_l


@both_models
def test_random_reads_are_limited_by_row_cycles(model):
    """One bank, another row each time: n_rc or the sum of its parts for each read."""
    spec = without_refresh("gddr3_700")
    count = 200
    rows = (np.arange(count) % 7) << spec.row.shift
    run = model.simulate(spec, LINE_BYTES, [stream(rows)])

    bursts = LINE_BYTES // (spec.burst_beats * spec.beat_bytes)
    timing = spec.timing
    cycle = timing.n_rcd_read + (bursts - 1) * timing.n_ccd + timing.n_rtp + timing.n_rp
    oldest_first = spec._replace(scheduler=0)
    in_order = model.simulate(oldest_first, LINE_BYTES, [stream(rows)])
    assert in_order.clocks == (count - 1) * max(cycle, timing.n_rc) + timing.n_rcd_read + up(
        read_clocks(spec)
    )
    assert run.clocks < in_order.clocks


@pytest.mark.parametrize("gap", [1, 40, 100])
def test_an_ideal_dram_has_one_latency(gap):
    spec = spec_of(preset("ideal"))
    run = compiled.simulate(spec, LINE_BYTES, [stream(np.arange(500) * LINE_BYTES, np.arange(500) * gap)])

    assert np.flatnonzero(run.latencies).tolist() == [25]
