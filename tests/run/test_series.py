"""Series over time: what an interval's ratios are, that intervals double when there are many, and that all adds up."""

import numpy as np
import pytest

from archsim.config import load_run
from archsim.machine.build import phase_machine
from archsim.machine.counters import no_counters
from archsim.machine.pipeline.build import pipeline_machine
from archsim.machine.series import sample_of
from archsim.run import simulate
from archsim.run.folder import plain
from archsim.run.series import INTERVALS, MOST_INTERVALS, Interval, Recorder

TINY = load_run("runs/tiny.yaml")
MACHINE = phase_machine(TINY.machine, "izb_build")
NOTHING = no_counters(MACHINE.spec)


def sample(cycle, **counts):
    return sample_of(cycle, NOTHING)._replace(**counts)


def test_too_many_intervals_become_half_as_many_of_twice_the_length():
    recorder = Recorder(10, MACHINE)
    for number in range(1, MOST_INTERVALS + 3):
        recorder.take(sample(10 * number, row_hits=number))

    assert recorder.interval_cycles == 20
    assert [each.cycle for each in recorder.samples] == list(range(20, 10 * MOST_INTERVALS + 30, 20))


def test_an_interval_is_the_difference_of_its_ends():
    begin, end = sample(100, row_hits=3, classified=8), sample(300, row_hits=5, classified=12)
    values = {measure.name: measure.value(Interval(MACHINE, begin, end)) for measure in INTERVALS}

    assert values["until_cycle"] == 300
    assert values["dram.row_hit_percent"] == 100 * 2 / 4


def test_an_interval_without_requests_has_no_hit_rate():
    recorder = Recorder(10, MACHINE)
    for cycle, number in ((10, 4), (20, 4), (30, 8)):
        lookups = np.full_like(NOTHING.cache_hits, number)
        recorder.take(sample(cycle, classified=number, lookups=lookups, hits=0 * lookups))

    series = recorder.series()

    for name in ("dram.row_hit_percent", "l2.hit_percent"):
        np.testing.assert_array_equal(series.columns[name], [0, np.nan, 0])
        assert plain(series.columns[name]) == [0, None, 0]
    assert series.columns["dram.bandwidth_bytes_per_cycle"] == [0, 0, 0]


def test_a_run_tells_its_series_when_asked_to():
    series = simulate(load_run("runs/tiny.yaml", ("statistics.interval_cycles=5000",))).series
    plain = simulate(TINY)

    assert plain.series == {}
    for phase in ("izb_build", "izb_raster"):
        cores = phase_machine(TINY.machine, phase).spec.core.num_cores
        useful = 100 * plain.value(f"{phase}.instructions") / cores
        assert sums_to(series[phase], "useful_percent", useful)
        assert sums_to(series[phase], "dram.bandwidth_bytes_per_cycle", plain.value(f"{phase}.dram.bytes"))


def test_a_phase_that_is_played_again_goes_on_where_it_was():
    recorder = Recorder(10, MACHINE)
    for _ in range(2):
        recorder.begin()
        for cycle in (10, 20, 24):
            recorder.take(sample(cycle, classified=4 * cycle, row_hits=cycle))

    columns = recorder.series().columns
    assert columns["until_cycle"] == [10, 20, 24, 34, 44, 48]
    assert columns["dram.row_hit_percent"] == [25] * 6


def sums_to(series, column, value):
    """Whether a ratio, of which four decimals are told, adds up to a value when weighed with the intervals' lengths."""
    lengths = np.diff([0, *series.columns["until_cycle"]])
    return (lengths * series.columns[column]).sum() == pytest.approx(
        value, rel=1e-6, abs=1e-4 * lengths.sum()
    )


def check_pipeline(result, phase, machine):
    """That a pipeline's series add up to the statistics of its phase."""
    series, cycles = result.series[phase], result.value(f"{phase}.cycles")
    assert sums_to(series, "dram.bandwidth_bytes_per_cycle", result.value(f"{phase}.dram.bytes"))
    for name in (*machine.units, *machine.channels):
        what = f"{name}.{'busy' if name in machine.units else 'fill'}_percent"
        assert sums_to(series, what, result.value(f"{phase}.{what}") * cycles)


SMALL = ("scene.resolution=[32,24]", "scene.mesh.parameters.knights=2", "statistics.interval_cycles=500")


def test_a_pipeline_tells_how_busy_units_and_how_full_fifos_and_delay_streams_are():
    config = load_run("runs/hsv_knights_hierarchical.yaml", SMALL)
    result = simulate(config)

    assert len(result.series["shadow_volumes"].columns["until_cycle"]) > 10
    check_pipeline(result, "shadow_volumes", pipeline_machine(config.machine))


def test_every_map_has_its_own_series():
    config = load_run("runs/lograster_tiny.yaml", ("statistics.interval_cycles=500",))
    result = simulate(config)

    assert list(result.series) == [name for name in dict.fromkeys(result.series) if name.startswith("map_")]
    for phase in result.series:
        check_pipeline(result, phase, pipeline_machine(config.machine))


def test_kernels_and_the_pipeline_beside_them_tell_theirs():
    config = load_run("runs/hsv_kernels_tiny.yaml", (*SMALL, "workload.psv_buffers=1"))  # several batches
    result = simulate(config)

    check_pipeline(result, "shadow_volumes", pipeline_machine(config.workload.fixed_function))
    cores = phase_machine(config.machine, "hsv_stages").spec.core.num_cores
    for phase in ("hsv_clear", "hsv_stage1", "hsv_stage2"):
        useful = 100 * result.value(f"{phase}.instructions") / cores
        assert sums_to(result.series[phase], "useful_percent", useful)
