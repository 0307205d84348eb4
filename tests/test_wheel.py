"""The built wheel in an empty environment, outside the checkout."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import archsim

ROOT = Path(archsim.__file__).parents[1]


def run(*command, cwd: Path) -> str:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        command,
        cwd=cwd,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.mark.slow
def test_the_wheel_reproduces_and_sweeps(tmp_path):
    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "-w", str(tmp_path), str(ROOT), cwd=tmp_path)
    run(sys.executable, "-m", "venv", str(tmp_path / "empty"), cwd=tmp_path)
    program = tmp_path / "empty" / "bin"
    run(str(program / "pip"), "install", "-q", *map(str, tmp_path.glob("*.whl")), cwd=tmp_path)

    assert "4 points finished" in run(
        str(program / "archsim"), "sweep", "tiny", "--shard", "1/2", "--out", "sweep", cwd=tmp_path
    )
    reproduced = run(str(program / "archsim"), "reproduce", "johnson2004", cwd=tmp_path)
    assert "written to runs/reproduce-johnson2004" in reproduced
    assert (tmp_path / "runs" / "reproduce-johnson2004" / "report.html").is_file()
