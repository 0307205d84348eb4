"""Pipelines whose wiring does not fit together, each mistake at its place."""

from __future__ import annotations

import pytest

from archsim.config import load_machine
from archsim.config.stages import StageConfig

C = "components."
HERE = "configs/machines/tiny_pipeline.yaml"


def test_the_teaching_machine_is_a_pipeline():
    machine = load_machine("machines/tiny_pipeline.yaml")

    assert machine.roles is None
    assert list(machine.all_of(StageConfig)) == ["setup", "classify", "shade", "blend"]


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (C + "shade.inputs=[hel]", "no fifo or delay_stream is named 'hel'; did you mean 'held'?"),
        (C + "shade.inputs=[tiles]", "must name a fifo or delay_stream; 'tiles' is a cache"),
        (C + "shade.pools=[buffer]", "no pool is named 'buffer'; did you mean 'buffers'?"),
        (C + "blend.memory=tile", "no cache or dram or ideal_dram is named 'tile'; did you mean 'tiles'?"),
        (C + "held.memory=tiles", "must name a dram or ideal_dram; 'tiles' is a cache"),
        (C + "blend.inputs=[]", "components.lit: exactly one unit must take from it; none does"),
        (C + "shade.outputs=[lit,lit]", "components.lit: exactly one unit must emit into it; shade, shade"),
        (C + "shade.clock=memory", "must be 'core', the clock of 'setup'"),
        (C + "tiles.clock=memory", "must be 'core', the clock of 'blend'"),
        (C + "blend.line=32 B", "must be left out: it goes with the DRAM as memory"),
        (C + "blend.memory=dram", "must be given: it goes with the DRAM as memory"),
        (C + "held.line=48 B", "components.held.line: must be a power of two, not 48 B"),
        (C + "held.line=16 B", "components.held.line: must be a whole number of bursts, 32 B each"),
        (C + "held.size=250 B", "components.held.size: must be a multiple of the line, 32 B"),
        (
            C + "held.address=8 MiB",
            "components.held.address: the ring ends at 8388864 B, beyond 'dram'; 'dram' holds 8 MiB",
        ),
        (C + "dram.rows=32", "components.held.address: the ring ends at 65792 B, beyond 'dram'"),
        (C + "held.overflow=releas", "must be stall or release, not 'releas'; did you mean 'release'?"),
        (C + "setup.interval_cycles=0", "must be at least 1, not 0"),
        (C + "setup.latency=3", "unknown key 'components.setup.latency'"),
        (C + "setup.lanes=0", "components.setup.lanes: must be at least 1, not 0"),
        (C + "setup.inputs=lit", "components.setup.inputs: must be a list, not 'lit'"),
    ],
)
def test_a_mistake_is_said_where_it_is(problems, override, message):
    found = problems(load_machine, "machines/tiny_pipeline.yaml", [override])

    assert message in found[0]


def test_a_pipeline_needs_a_source(problems):
    found = problems(load_machine, "machines/tiny_pipeline.yaml", [C + "setup.inputs=[lit]"])

    assert any("a pipeline needs a source: a unit without inputs" in each for each in found)


def test_cores_need_roles(problems, write):
    write("machine.yaml", "base: machines/tiny.yaml\nroles: null\n")

    assert problems(load_machine, "machine.yaml") == [
        "machine.yaml:1:1: the file: missing key 'roles': which cores run which phase"
    ]


def test_a_missing_key_is_named(problems, write):
    write(
        "machine.yaml",
        """\
        base: machines/tiny_pipeline.yaml
        components:
          more: {kind: unit, clock: core, interval_cycles: 1, inputs: [], outputs: []}
        """,
    )

    assert problems(load_machine, "machine.yaml") == [
        "machine.yaml:3:3: missing key 'components.more.latency_cycles'",
        "machine.yaml:3:3: missing key 'components.more.in_flight'",
    ]
