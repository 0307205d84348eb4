"""The run folder: whole or not there, readable again, the same bytes for the same run."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from archsim.errors import ArchsimError
from archsim.run.folder import (
    RunFiles,
    check_target,
    load_folder,
    publish,
    result_json,
    write_run,
)
from archsim.run.result import Check, Statistic
from tests.run.results import CONFIG_YAML, MANIFEST, make_result

FILES = {"config.yaml", "manifest.json", "report.html", "result.json", "shadow.npy", "shadow.png"}


def files(result=None) -> RunFiles:
    return RunFiles(result or make_result(), CONFIG_YAML, MANIFEST, "<html></html>")


def test_a_folder_holds_all_files_and_can_be_read_back(tmp_path):
    out = write_run(tmp_path / "deep" / "run", files())

    stored = load_folder(out)

    assert {path.name for path in out.iterdir()} == FILES
    assert stored.result.statistics == make_result().statistics
    assert stored.result.checks == [Check("a law", True, "1 = 1")]
    np.testing.assert_array_equal(stored.result.shadow, make_result().shadow)
    assert stored.manifest == MANIFEST
    assert stored.config_yaml == CONFIG_YAML
    assert [path.name for path in out.parent.iterdir()] == ["run"]  # nothing temporary is left


def test_the_mask_is_stored_row_0_first_and_shadow_is_darker(tmp_path):
    out = write_run(tmp_path / "run", files())

    mask, picture = np.load(out / "shadow.npy"), imread(out / "shadow.png")[..., :3].mean(axis=2)

    assert mask.dtype == np.bool_
    np.testing.assert_array_equal(mask, make_result().shadow)
    assert picture.shape == mask.shape
    assert picture[mask].max() < picture[~mask].min() - 0.3


def test_what_is_not_finite_becomes_null_in_json(tmp_path):
    values = [Statistic("a", float("nan"), "", ""), Statistic("b", np.float64("inf"), "", "")]
    result = make_result(statistics=values, summary={"worst": float("-inf"), "n": np.int64(3)})

    tree = json.loads(result_json(result), parse_constant=pytest.fail)

    assert [item["value"] for item in tree["statistics"]] == [None, None]
    assert tree["summary"] == {"worst": None, "n": 3}
    out = write_run(tmp_path / "run", files(result))
    assert all(np.isnan(statistic.value) for statistic in load_folder(out).result.statistics)


def test_the_same_result_gives_the_same_bytes(tmp_path):
    first = write_run(tmp_path / "a", files())
    second = write_run(tmp_path / "b", files())

    for name in FILES - {"manifest.json"}:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name


def test_without_a_name_every_run_gets_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    names = [write_run(None, files(make_result(name="a b/c"))) for _ in range(3)]

    assert names == [Path("runs/a-b-c"), Path("runs/a-b-c-2"), Path("runs/a-b-c-3")]
    assert all(load_folder(name) for name in names)


def test_an_old_run_is_replaced_as_a_whole(tmp_path):
    out = write_run(tmp_path / "run", files())
    (out / "left_over.txt").write_text("from the old run")

    write_run(out, files(make_result(name="new")))

    assert {path.name for path in out.iterdir()} == FILES
    assert load_folder(out).result.name == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_something_else_is_never_replaced(tmp_path):
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "thesis.tex").write_text("years of work")
    (tmp_path / "file").write_text("text")

    for name in ("notes", "file"):
        with pytest.raises(ArchsimError, match=name):
            check_target(tmp_path / name)
        with pytest.raises(ArchsimError, match=name):
            write_run(tmp_path / name, files())

    assert (tmp_path / "notes" / "thesis.tex").read_text() == "years of work"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "notes"]


def test_an_error_while_writing_leaves_the_old_run(tmp_path):
    out = write_run(tmp_path / "run", files())

    def fails(folder: Path) -> None:
        (folder / "half").write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(ArchsimError, match="run: cannot write the folder: No space left on device"):
        publish(out, True, fails)

    assert load_folder(out).result.name == "made_up"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


WRITES_SLOWLY = """
import sys, time
from pathlib import Path
from archsim.run.folder import publish

def fill(folder):
    (folder / "result.json").write_text("{}")
    print("half done", flush=True)
    time.sleep(60)

publish(Path(sys.argv[1]), True, fill)
"""


@pytest.mark.parametrize("signal_number", [signal.SIGKILL, signal.SIGINT])
def test_a_killed_run_leaves_nothing_that_looks_finished(tmp_path, signal_number):
    process = subprocess.Popen(
        [sys.executable, "-c", WRITES_SLOWLY, str(tmp_path / "run")],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "half done\n"
        time.sleep(0.05)
        os.kill(process.pid, signal_number)
        process.wait(10)

    assert not (tmp_path / "run").exists()
    for path in tmp_path.iterdir():
        assert path.name.startswith(".")
        with pytest.raises(ArchsimError, match="is not an archsim run"):
            load_folder(path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("result.json", b"{", r"result.json:1:2: is not JSON"),
        ("result.json", b"[]", "is not a JSON object"),
        ("result.json", b"{}", "is not a result: 'name'"),
        ("manifest.json", b"\xff", "manifest.json: cannot be read"),
        ("shadow.npy", b"no array", "shadow.npy: cannot be read"),
        ("config.yaml", None, "config.yaml: cannot be read: No such file"),
    ],
)
def test_a_broken_folder_names_the_file(tmp_path, name, content, message):
    out = write_run(tmp_path / "run", files())
    (out / name).unlink()
    if content is not None:
        (out / name).write_bytes(content)

    with pytest.raises(ArchsimError, match=message):
        load_folder(out)


def test_folders_that_are_no_runs_are_named(tmp_path):
    with pytest.raises(ArchsimError, match="no such run folder"):
        load_folder(tmp_path / "none")
    with pytest.raises(ArchsimError, match=r"has no manifest\.json"):
        load_folder(tmp_path)


def test_a_target_below_a_file_is_refused_before_the_work(tmp_path):
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(ArchsimError, match="file' is not a folder"):
        check_target(tmp_path / "file" / "run")
    check_target(tmp_path / "new" / "deep" / "run")
