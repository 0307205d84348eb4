"""The contract of the statistics: one definition each, no counter unused, a reference that is the code's."""

import re
from pathlib import Path

import numpy as np
import pytest

import archsim
from archsim.config import load_run
from archsim.machine.build import phase_machine
from archsim.machine.counters import Counters, no_counters
from archsim.run import simulate
from archsim.run.catalogue import entries, reference
from archsim.run.measure import Measure, measured
from archsim.run.metrics import phase_statistics

TINY = load_run("runs/tiny.yaml", ["scene.resolution=[32, 24]"])


def pattern(name: str) -> re.Pattern:
    """What a name with braces stands for."""
    return re.compile(re.sub(r"\\\{\w+\\\}", "[A-Za-z0-9_]+", re.escape(name)))


@pytest.fixture(scope="module")
def statistics():
    return simulate(TINY).statistics


def test_every_statistic_of_a_run_is_defined(statistics):
    for statistic in statistics:
        fitting = {measure.unit for name, measure in entries() if pattern(name).fullmatch(statistic.name)}
        assert statistic.unit in fitting, statistic.name


def test_names_units_and_definitions_are_there_once():
    names = [name for name, _ in entries()]

    assert len(names) == len(set(names))
    for name, measure in entries():
        assert measure.unit, name
        assert re.fullmatch(r"[A-Z].*[a-z0-9`)}]\.", measure.definition, re.DOTALL), name


def test_the_printed_reference_is_the_codes():
    page = Path(archsim.__file__).parent / "docs" / "reference" / "statistics.md"
    assert page.read_text() == reference(), f"run: archsim statistics > {page}"


@pytest.mark.parametrize("counter", Counters._fields)
def test_every_counter_moves_a_statistic(counter):
    machine = phase_machine(TINY.machine, "izb_build")
    nothing = no_counters(machine.spec)
    before = nothing._replace(cycles=1000, locks_waited=10, cache_fetches=nothing.cache_fetches + 10)
    value = getattr(before, counter)
    after = before._replace(**{counter: value + np.ones_like(value) if np.ndim(value) else value + 1})

    changed = [
        a.name
        for a, b in zip(
            phase_statistics("p", machine, before), phase_statistics("p", machine, after), strict=True
        )
        if a.value != b.value
    ]

    assert changed


def test_names_in_braces_are_filled():
    table = [Measure("stall.{level}_percent", "%", "Waiting for {level}.", lambda view: np.int64(view))]

    (statistic,) = measured("p", table, 3, level="l2")

    assert statistic == ("p.stall.l2_percent", 3, "%", "Waiting for l2.")
    assert type(statistic.value) is int
