"""`archsim timeline`."""

import json

import pytest
from typer.testing import CliRunner

from archsim.cli.app import app


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def archsim_(*arguments, exit_code=0):
    result = CliRunner().invoke(app, ["timeline", *arguments])
    assert result.exit_code == exit_code, result.output
    return result


def test_a_trace_and_a_waterfall_are_left(tmp_path):
    small = ["tiny", "--set", "scene.resolution=[16, 12]"]

    out = archsim_(*small, "--phase", "izb_build", "--tasks", "1:3", "--waterfall", "40").stdout

    assert out.startswith("cycles 0 to 39\ncore 0 thread  0 |c")
    assert json.loads((tmp_path / "timeline.json").read_text())["traceEvents"]
    assert "<svg" in (tmp_path / "timeline.svg").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--phase", "izb_rastr"], "did you mean 'izb_raster'"),
        (["--tasks", "5:2"], "a range is written FIRST:LAST"),
        (["--tasks", "99999:100000"], "none of them from 99999 on"),
    ],
)
def test_bad_input_ends_with_2(arguments, message):
    assert message in archsim_("tiny", "--set", "scene.resolution=[16, 12]", *arguments, exit_code=2).stderr
