"""What only a run's start finds is said with the place of the value that it is about."""

from pathlib import Path

import pytest

from archsim.config import load_run_with_origins
from archsim.errors import ArchsimError
from archsim.run import simulate
from archsim.run.progress import silent

GENERATED = """\
base: runs/tiny.yaml
scene:
  mesh:
    generator: knot_and_spheres
    parameters:
      knot_radios: 3
      num_spheres: -1
"""


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def problems_of(name, *overrides):
    loaded = load_run_with_origins(name, overrides)
    with pytest.raises(ArchsimError) as caught, loaded.locating():
        simulate(loaded.config, silent)
    return [str(problem) for problem in caught.value.problems]


def test_every_wrong_parameter_of_a_generator_has_its_line():
    Path("mine.yaml").write_text(GENERATED)

    misspelt, negative = problems_of("mine.yaml")

    assert misspelt.startswith("mine.yaml:6:20: generator 'knot_and_spheres': there is no parameter")
    assert misspelt.endswith("did you mean 'knot_radius'?")
    assert negative.startswith("mine.yaml:7:20: ")
    assert negative.endswith("num_spheres must be at least 0, not -1")


def test_what_is_in_a_mesh_file_is_about_the_mesh_of_the_scene():
    Path("bad.obj").write_text("v 0 0 0\nv 1 0 0\nf 1 2 9\n")
    Path("mine.yaml").write_text("base: runs/tiny.yaml\nscene:\n  mesh: bad.obj\n")

    (problem,) = problems_of("mine.yaml")

    assert problem.startswith("mine.yaml:3:9: mesh '")
    assert "bad.obj'" in problem


def test_too_few_locks_and_too_small_a_dram_are_said_at_once():
    locks, dram = problems_of(
        "runs/tiny.yaml", "machine.components.locks.count=2", "machine.components.dram.rows=1"
    )

    assert locks.startswith("--set machine.components.locks.count=2: the kernels use 256 locks")
    assert dram.startswith("--set machine.components.dram.rows=1: the arrays of this run end at")


def test_without_a_file_the_key_is_said():
    loaded = load_run_with_origins("runs/tiny.yaml", ["machine.components.dram.rows=1"])

    with pytest.raises(ArchsimError, match=r"^machine\.components\.dram\.rows: the arrays"):
        simulate(loaded.config, silent)
