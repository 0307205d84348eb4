"""The laws of pipelines hold on every machine, and notice faults; every counter is a statistic."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from archsim.config import load_machine
from archsim.machine.pipeline import compiled
from archsim.machine.pipeline.build import PipelineMachine, pipeline_machine
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.pipeline.play import play
from archsim.run.pipeline_metrics import pipeline_checks, pipeline_statistics
from tests.machine.pipeline.build import chunks
from tests.machine.pipeline.strategies import cases
from tests.machine.pipeline.test_tiny import objects


def named(spec):
    """The spec with a name for each component."""
    units = tuple("abcdefgh"[: len(spec.units)])
    channels = tuple(f"channel_{k}" for k in range(spec.num_channels))
    caches = tuple(f"cache_{k}" for k in range(len(spec.caches)))
    return PipelineMachine(spec, units, channels, ("pool",) * len(spec.pools), caches, 10**9, 2**20)


@pytest.fixture(scope="module")
def machine():
    return pipeline_machine(load_machine("machines/tiny_pipeline.yaml"))


@pytest.fixture(scope="module")
def counters(machine):
    return play("compiled", machine, objects([3, 5, 20, 1]))


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(cases())
def test_the_laws_hold(case):
    machine = named(case.spec)
    listed = case.chunks or (tuple([] for _ in machine.units),)
    checks = pipeline_checks("p", machine, compiled.simulate(case.spec, chunks(*listed)))

    assert not [check for check in checks if not check.ok]


@pytest.mark.parametrize(
    ("counter", "law"),
    [
        ("unit_slots", "p: slots"),
        ("channel_put", "p: items"),
        ("pool_released", "p: tokens"),
        ("stream_writes", "p: writes reach the DRAM"),
        ("stream_reads", "p: reads reach the DRAM"),
        ("unit_loads", "p: reads of cache tiles"),
        ("unit_stores", "p: writes of cache tiles"),
    ],
)
def test_a_lost_event_breaks_a_law(machine, counters, counter, law):
    value = getattr(counters, counter).copy()
    value[-1] -= 1
    broken = pipeline_checks("p", machine, counters._replace(**{counter: value}))

    assert law in [check.name for check in broken if not check.ok]


@pytest.mark.parametrize("counter", [name for name in PipelineCounters._fields if name != "memory"])
def test_every_counter_moves_a_statistic_or_a_law(machine, counters, counter):
    value = getattr(counters, counter)
    changed = value + (np.arange(np.size(value)).reshape(np.shape(value)) + 1)
    before, after = (
        (pipeline_statistics("p", machine, each), pipeline_checks("p", machine, each))
        for each in (counters, counters._replace(**{counter: changed}))
    )

    assert before != after


def test_names_are_phase_component_what(machine, counters):
    values = {each.name: each.value for each in pipeline_statistics("p", machine, counters)}

    assert values["p.cycles"] == counters.cycles
    assert values["p.shade.tasks"] == 29
    assert values["p.held.early"] == 4
    assert values["p.buffers.peak"] == 2
    assert values["p.tiles.reads"] == 29
    assert values["p.dram.reads"] > 0
