"""Ideal parts are machines like any other, and cost nothing where they are ideal."""

import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.run import simulate
from archsim.sweep.expand import overrides
from archsim.sweep.plan import make_plan
from archsim.sweep.whatif import ideal_parts, outcomes, whatif_sweep

SMALL = ["scene.resolution=[16, 12]"]


@pytest.mark.parametrize("run", ["tiny", "izb_knot", "lograster_tiny", "hsv_knights_hierarchical"])
def test_every_idea_and_pair_is_a_run(run):
    config = load_run(f"runs/{run}.yaml")
    pairs = "izb" in run or run == "tiny"
    sweep, chosen = whatif_sweep(config, f"runs/{run}.yaml", pairs)

    points = make_plan(sweep.config, f"runs/{run}.yaml")

    assert len(points) == len(chosen) == len({point.digest for point in points})  # equal pairs only once
    assert {(idea,) for idea in ideal_parts(config)} <= set(chosen)
    assert max(map(len, chosen)) == 1 + pairs
    assert [point.error for point in points if point.error] == []


def test_only_what_is_not_ideal_already_is_an_idea():
    tiny = ideal_parts(load_run("runs/tiny.yaml"))
    limited = [
        "machine.components.rasterizer.interval_cycles=3",
        "machine.components.dram.timing.n_refi=5000",
    ]

    assert "ideal rasterizer" not in tiny
    assert "no refresh" not in tiny
    assert set(ideal_parts(load_run("runs/tiny.yaml", limited))) == {*tiny, "ideal rasterizer", "no refresh"}


def test_units_of_a_pipeline_are_parts_too():
    found = ideal_parts(load_run("runs/hsv_knights_hierarchical.yaml"))

    assert {"ideal stage_1", "ideal stencil", "instant memory", "unlimited fifos"} <= set(found)
    assert not {"perfect L1", "zero lock cost"} & set(found)
    assert found["ideal stage_1"].keys() <= {
        f"machine.components.stage_1.{key}" for key in ("interval_cycles", "latency_cycles", "lanes")
    }


def ideal(idea):
    config = load_run("runs/tiny.yaml", SMALL)
    return simulate(load_run("runs/tiny.yaml", [*SMALL, *overrides(ideal_parts(config)[idea])]))


def test_ideal_locks_are_never_waited_for():
    result = ideal("zero lock cost")

    assert result.ok
    assert result.value("izb_build.locks.waited") == 0
    assert result.value("izb_build.stall.lock_percent") == 0
    assert result.value("izb_build.locks.taken") > 0


def test_a_perfect_second_level_answers_in_little_more_than_its_hit_time():
    """4 cycles in the tiny machine, one or two more where the line is not there yet."""
    result = ideal("perfect L2")

    assert result.ok
    assert 4 <= result.value("izb_raster.shader_l1.average_miss_cycles") <= 6


def test_a_perfect_first_level_leaves_little_to_wait_for():
    result = ideal("perfect L1")

    assert result.ok
    assert result.value("izb_raster.useful_percent") > 90


def test_speedups_are_ranked_and_failures_left_out():
    chosen = [(), ("a",), ("b",), ("a", "b")]
    cycles = [{"p": 60, "q": 40}, {"p": 50, "q": 30}, None, {"p": 20, "q": 5}]

    found = outcomes(chosen, cycles)

    assert [(outcome.ideas, outcome.speedup) for outcome in found] == [
        (("a", "b"), 4),
        (("a",), 1.25),
        ((), 1),
    ]
    with pytest.raises(ArchsimError, match="as it is could not be measured"):
        outcomes(chosen, [None] * 4)
