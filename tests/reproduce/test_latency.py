"""Unloaded latencies, measured on the paper's machine and on the teaching machine."""

import pytest

from archsim.config import load_machine
from archsim.machine.build import phase_machine
from archsim.reproduce.latency import minimum_miss_cycles


@pytest.mark.parametrize("role", ["izb_build", "izb_raster"])
def test_the_paper_s_machine_has_the_printed_minima(role):
    spec = phase_machine(load_machine("machines/johnson2004.yaml"), role).spec

    assert minimum_miss_cycles(spec, spec.core_cache[0]) == {"L1": 6.0, "L2": 42.0}


def test_the_minimum_follows_the_timing():
    """L2 of the teaching machine: n_cl 3 + 2 bursts of 4 clocks - 1/2, at two cycles a clock."""
    spec = phase_machine(load_machine("machines/tiny.yaml", ["clocks.memory=500 MHz"]), "izb_build").spec

    assert minimum_miss_cycles(spec, spec.core_cache[0]) == {"L1": 4.0, "L2": 2 * (3 + 8 - 0.5)}
