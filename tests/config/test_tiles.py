"""Evaluators and tile caches of a machine: what cannot be is said where it is written."""

from __future__ import annotations

import pytest

from archsim.config import load_machine
from archsim.config.stages import StageConfig
from archsim.machine.pipeline.build import pipeline_machine

C = "components."
MACHINE = "machines/lloyd2007.yaml"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (
            C + "fine.parts=[evaluater]",
            "no evaluator or tile_cache is named 'evaluater'; did you mean 'evaluator'?",
        ),
        (C + "fine.parts=[dram]", "must name a evaluator or tile_cache; 'dram' is a dram"),
        (C + "evaluator.design=tables", "must be full, incremental, table or table_first_row, not 'tables'"),
        (C + "evaluator.exponentials=0", "components.evaluator.exponentials: must be at least 1, not 0"),
        (C + "evaluator.constant_bits=37", "components.evaluator.constant_bits: must be at most 36, not 37"),
        (C + "z_cache.size=24 KB", "components.z_cache.size"),
        (C + "z_cache.size=1000 B", "must be a multiple of 4 ways of 48 B, not 1000 B"),
        (C + "z_cache.tile=8", "components.z_cache.codec: 'lloyd' is not defined for tiles of 8 x 8"),
        (C + "z_cache.tile=5", "components.z_cache.tile"),
        (C + "z_cache.granularity=64 B", "must be at most a tile, 48 B, not 64 B"),
        (C + "z_cache.codec=hasselgreen", "did you mean 'hasselgren'?"),
    ],
)
def test_a_mistake_is_said_where_it_is(problems, override, message):
    found = problems(load_machine, MACHINE, [override])

    assert any(message in each for each in found), found


def test_a_table_needs_a_memory(problems):
    found = problems(
        load_machine,
        MACHINE,
        [C + "evaluator.design=table", C + "fine.memory=null", C + "fine.line=null"],
    )

    assert (
        "components.evaluator.design: 'table' is in memory, and no unit with this part has a memory"
        in found[0]
    )


def test_parts_that_no_unit_is_made_with_take_no_part(problems):
    found = problems(load_machine, MACHINE, [C + "depth_test.parts=[]"])

    assert any("components.z_cache: takes no part" in each for each in found)


@pytest.mark.parametrize(
    ("design", "exponentials", "interval", "latency"),
    [
        ("full", 4, 1, 15),
        ("full", 1, 4, 15),
        ("full", 3, 2, 15),
        ("incremental", 1, 1, 18),
        ("table", 1, 1, 6),
    ],
)
def test_a_unit_is_no_faster_than_its_evaluator(design, exponentials, interval, latency):
    """Exponentials of 11 cycles, multiply-adds of 3, table accesses of 2, a cycle for the other columns."""
    overrides = [C + f"evaluator.design={design}", C + f"evaluator.exponentials={exponentials}"]
    config = load_machine(MACHINE, overrides)
    machine = pipeline_machine(config)
    stages = dict(zip(machine.units, machine.spec.units, strict=True))

    assert (stages["fine"].interval_cycles, stages["fine"].latency_cycles) == (interval, latency)
    assert stages["z_cull"].latency_cycles == config.find("z_cull", StageConfig).latency_cycles
    slow = pipeline_machine(load_machine(MACHINE, [*overrides, C + "fine.latency_cycles=40"]))
    assert dict(zip(slow.units, slow.spec.units, strict=True))["fine"].latency_cycles == 40
