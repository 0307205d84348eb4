"""The example scripts of the experiments run, on small pictures."""

import subprocess
import sys

from archsim import resources


def test_the_example_of_johnson2004_runs(tmp_path):
    script = resources.experiment("johnson2004") / "example.py"

    done = subprocess.run(
        [sys.executable, script, "32", "24"], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert done.returncode == 0, done.stderr
    assert "izb_build.cycles_per_point" in done.stdout
    assert len(done.stdout.splitlines()) == 3 + 6 + 5
    assert list(tmp_path.iterdir()) == []
