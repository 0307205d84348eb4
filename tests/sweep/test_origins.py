"""Who set the values of a sweep's points."""

import pytest

from archsim.config import load_sweep_with_origins
from archsim.sweep.expand import expand
from archsim.sweep.origins import parameter_origins

SWEEP = """\
name: example
run: runs/tiny.yaml
set: {model: compiled, scene.resolution: [16, 12]}
parameters:
  - grid: {model: [reference, compiled]}
  - zip:
      machine.components.l2.size: [1 KiB, 2 KiB]
  - list: [{workload.light: 0}, {workload.depth_offset_cells: 0.5}]
  - random: {count: 2, seed: 3, values: {machine.components.l2.ways: {low: 1, high: 1}}}
seeds: 10
"""


@pytest.fixture
def found(tmp_path):
    (tmp_path / "example.yaml").write_text(SWEEP)
    loaded = load_sweep_with_origins(tmp_path / "example.yaml")
    points = [{**loaded.config.set, **parameters} for parameters in expand(loaded.config)]
    return {origin.key: origin for origin in parameter_origins(loaded, points)}


@pytest.mark.parametrize(
    ("key", "value", "line"),
    [
        ("scene.resolution", "[16, 12]", 3),
        ("model", "reference, compiled", 5),  # a block goes before `set`
        ("machine.components.l2.size", "1 KiB, 2 KiB", 7),
        ("workload.depth_offset_cells", "0.5", 8),
        ("machine.components.l2.ways", "1", 9),
        ("seed", "0, 1 ... 9 (10 values)", 10),
    ],
)
def test_a_parameter_has_its_values_and_its_line_in_the_sweeps_file(found, key, value, line):
    assert found[key].value == value
    assert f"example.yaml:{line}:" in found[key].place
