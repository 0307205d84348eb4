"""Series over time: what an interval's ratios are, that intervals double when there are many, and that all adds up."""

import numpy as np
import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.machine.build import phase_machine
from archsim.machine.counters import no_counters
from archsim.machine.series import sample_of
from archsim.run import simulate
from archsim.run.series import INTERVALS, MOST_INTERVALS, Interval, Recorder

TINY = load_run("runs/tiny.yaml")
MACHINE = phase_machine(TINY.machine, "izb_build")
NOTHING = no_counters(MACHINE.spec)


def sample(cycle, **counts):
    return sample_of(cycle, NOTHING)._replace(**counts)


def test_too_many_intervals_become_half_as_many_of_twice_the_length():
    recorder = Recorder(10)
    for number in range(1, MOST_INTERVALS + 3):
        recorder.take(sample(10 * number, useful=number))

    assert recorder.interval_cycles == 20
    assert [each.cycle for each in recorder.samples] == list(range(20, 10 * MOST_INTERVALS + 30, 20))


def test_an_interval_is_the_difference_of_its_ends():
    begin, end = sample(100, row_hits=3, classified=8), sample(300, row_hits=5, classified=12)
    values = {measure.name: measure.value(Interval(MACHINE, begin, end)) for measure in INTERVALS}

    assert values["until_cycle"] == 300
    assert values["dram.row_hit_percent"] == 100 * 2 / 4


def test_a_run_tells_its_series_when_asked_to():
    series = simulate(load_run("runs/tiny.yaml", ("statistics.interval_cycles=5000",))).series
    plain = simulate(TINY)

    assert plain.series == {}
    for phase in ("izb_build", "izb_raster"):
        columns = series[phase].columns
        lengths = np.diff([0, *columns["until_cycle"]])
        cores = phase_machine(TINY.machine, phase).spec.core.num_cores
        useful = (lengths * columns["useful_percent"]).sum() * cores / 100.0
        moved = (lengths * columns["dram.bandwidth_bytes_per_cycle"]).sum()
        assert useful == pytest.approx(plain.value(f"{phase}.instructions"), rel=1e-3)
        assert moved == pytest.approx(plain.value(f"{phase}.dram.bytes"), rel=1e-3)


def test_a_pipeline_tells_none():
    with pytest.raises(ArchsimError, match="tells no series over time"):
        load_run("runs/hsv_knights_hierarchical.yaml", ("statistics.interval_cycles=5000",))
