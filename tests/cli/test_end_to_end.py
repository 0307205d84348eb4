"""The installed command on the smallest run, as a user starts it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

ARCHSIM = Path(sys.executable).with_name("archsim")


def archsim_(folder, *arguments):
    return subprocess.run([ARCHSIM, *arguments], cwd=folder, capture_output=True, text=True, check=False)


def test_both_models_and_a_repetition_give_the_same_result(tmp_path):
    first = archsim_(tmp_path, "run", "tiny", "--json")
    again = archsim_(tmp_path, "run", "tiny", "--json")
    reference = archsim_(tmp_path, "run", "tiny", "--model", "reference", "--json")

    assert [run.returncode for run in (first, again, reference)] == [0, 0, 0], first.stderr
    assert first.stdout == again.stdout == reference.stdout
    assert all(check["ok"] for check in json.loads(first.stdout)["checks"])
    folders = sorted(path.name for path in (tmp_path / "runs").iterdir())
    assert folders == ["tiny", "tiny-2", "tiny-3"]
    shadows = [np.load(tmp_path / "runs" / name / "shadow.npy") for name in folders]
    assert 0 < shadows[0].sum() < shadows[0].size
    for name in ("result.json", "shadow.npy", "shadow.png"):
        assert len({(tmp_path / "runs" / folder / name).read_bytes() for folder in folders}) == 1


def test_shadow_maps_run_from_the_command_line_with_either_model(tmp_path):
    machine = [
        "--set",
        "machine.components.evaluator.design=table",
        "--set",
        "machine.components.z_cache.ways=2",
    ]
    first = archsim_(tmp_path, "run", "lograster_tiny", "--json", *machine)
    reference = archsim_(tmp_path, "run", "lograster_tiny", "--json", *machine, "--model", "reference")
    wrong = archsim_(tmp_path, "run", "lograster_tiny", "--set", "machine.components.z_cache.codec=loyd")

    assert (first.returncode, reference.returncode, wrong.returncode) == (0, 0, 2), first.stderr
    assert first.stdout == reference.stdout
    assert all(check["ok"] for check in json.loads(first.stdout)["checks"])
    assert "did you mean 'lloyd'?" in wrong.stderr


def test_the_resolved_configuration_repeats_the_run(tmp_path):
    first = archsim_(tmp_path, "run", "tiny", "--json", "--out", "first")
    again = archsim_(tmp_path, "run", "first/config.yaml", "--json", "--out", "again")

    assert again.stdout == first.stdout


@pytest.mark.parametrize("signal_number", [signal.SIGKILL, signal.SIGINT])
def test_a_run_killed_midway_leaves_nothing(tmp_path, signal_number):
    command = [ARCHSIM, "run", "izb_knot"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        time.sleep(1.5)
        os.kill(process.pid, signal_number)
        process.communicate(timeout=60)

    assert process.returncode == (-signal.SIGKILL if signal_number == signal.SIGKILL else 130)
    assert list(tmp_path.iterdir()) == []


def test_bad_input_ends_with_2_and_no_traceback(tmp_path):
    result = archsim_(tmp_path, "run", "tiny", "--set", "machine.components.l2.size=3000 B")

    assert result.returncode == 2
    assert "machine.components.l2.size" in result.stderr
    assert "Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_ends_with_2_and_one_line(tmp_path):
    command = f"{ARCHSIM} config show tiny > /dev/full"
    result = subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert result.returncode == 2
    assert result.stderr.splitlines() == ["cannot write: No space left on device"]


def test_a_reader_that_has_seen_enough_is_no_error(tmp_path):
    result = subprocess.run(
        f"{ARCHSIM} asm izb_build | head -n 1",
        shell=True,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )

    assert result.stdout.strip() == "!!VP2.0"
    assert result.stderr == ""


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").touch()
    result = archsim_(tmp_path, "trace", "export", "tiny", "--format", "dinero", "--out", "file/trace.din")
    assert result.returncode == 2
    assert result.stderr == "file/.trace.din-unfinished: Not a directory\n"

    result = archsim_(tmp_path, "sweep", "tiny", "--out", "file/sweep")
    assert result.returncode == 2
    assert result.stderr == f"file/sweep: '{tmp_path}/file' is not a folder; name a new folder with --out\n"
