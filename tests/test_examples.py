"""The example scripts of the experiments run, on small pictures."""

import subprocess
import sys

from archsim import resources


def lines(paper, tmp_path, *arguments):
    """What the example of a paper prints."""
    script = resources.experiment(paper) / "example.py"
    done = subprocess.run(
        [sys.executable, script, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert list(tmp_path.iterdir()) == []
    return done.stdout.splitlines()


def test_the_example_of_johnson2004_runs(tmp_path):
    found = lines("johnson2004", tmp_path, "32", "24")

    assert found[0].startswith("izb_build.cycles_per_point")
    assert any("izb_raster.stall" in line for line in found)


def test_the_example_of_aila2004_runs(tmp_path):
    found = lines("aila2004", tmp_path, "32", "24")

    assert found[0].split() == ["brute_force", "hierarchical"]
    assert sum("times less hierarchically" in line for line in found) == 2


def test_the_example_of_lloyd2007_runs(tmp_path):
    found = lines("lloyd2007", tmp_path, "64")

    assert found[0].split() == ["logarithmic", "linear"]
    assert any(line.startswith("checks_passed") for line in found)
