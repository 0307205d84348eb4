"""A sweep killed at random moments loses nothing that was finished and has nothing that only looks finished."""

import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest

import archsim
from archsim.config.document import dump
from archsim.run import simulate
from archsim.run.folder import result_json
from archsim.sweep.plan import make_plan
from tests.sweep.small import SWEEP, sweep

IZB = {
    "parameters": [
        {
            "grid": {
                "machine.components.l2.size": ["1 KiB", "2 KiB", "4 KiB"],
                "seed": [1, 2],
                "model": ["reference", "compiled"],
            }
        }
    ]
}
MAPS = {
    "run": "runs/lograster_tiny.yaml",
    "set": {"workload.texels": [32, 32], "scene.resolution": [16, 12]},
    "parameters": [
        {
            "grid": {
                "machine.components.z_cache.codec": ["lloyd", "none"],
                "machine.components.fine.interval_cycles": [1, 2, 3],
                "machine.components.dram.scheduler": ["fcfs", "fr_fcfs"],
            }
        }
    ],
}
KILLS = 4


def whole_points(folder):
    """Digest -> text of the points that look finished; each must be whole."""
    found = {}
    for path in (folder / "points").glob("[!.]*"):
        assert {each.name for each in path.iterdir()} == {"config.yaml", "manifest.json", "result.json"}
        json.loads((path / "manifest.json").read_text())
        found[path.name] = (path / "result.json").read_text()
    return found


@pytest.mark.parametrize("changes", [IZB, MAPS], ids=["izb", "maps"])
def test_killed_again_and_again(tmp_path, changes):
    (tmp_path / "sweep.yaml").write_text(dump({**SWEEP, **changes}))
    command = [sys.executable, "-m", "archsim", "sweep", "sweep.yaml", "--out", "out", "--jobs", "2"]
    environment = {**os.environ, "PYTHONPATH": os.path.dirname(os.path.dirname(archsim.__file__))}
    generator, before = random.Random(7), {}

    for _ in range(KILLS):
        process = subprocess.Popen(
            command, cwd=tmp_path, env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL
        )
        deadline = time.monotonic() + 60
        while len(whole_points(tmp_path / "out")) == len(before) and process.poll() is None:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        time.sleep(generator.uniform(0, 0.2))
        os.kill(process.pid, signal.SIGKILL)
        process.wait(10)
        now = whole_points(tmp_path / "out")
        assert before.items() <= now.items()
        before = now

    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    config = sweep(**changes)
    expected = make_plan(config, config.run)
    assert whole_points(tmp_path / "out") == {
        point.digest: result_json(simulate(point.config)) for point in expected
    }
    assert not [path for path in (tmp_path / "out" / "points").iterdir() if path.name.startswith(".")]
