"""`archsim walkthrough`, and the frames of `archsim reproduce`."""

import json

import pytest
from typer.testing import CliRunner

from archsim.cli.app import app

SMALL = ["--set", "scene.resolution=[64,48]", "--set", "frames=2"]


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def archsim_(*arguments, exit_code=0):
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == exit_code, result.output
    return result


def test_a_walkthrough_leaves_a_folder_and_no_frames(in_an_empty_folder):
    first = archsim_("walkthrough", "aila2004/simple", *SMALL).stdout
    assert "written to runs/walkthrough-simple" in first
    assert [path.name for path in (in_an_empty_folder / "runs").iterdir()] == ["walkthrough-simple"]
    page = (in_an_empty_folder / "runs" / "walkthrough-simple" / "report.html").read_text()
    for place in ("experiments/aila2004/simple.yaml:", "--set frames=2", "the default"):
        assert place in page
    again = archsim_("walkthrough", "aila2004/simple", *SMALL, "--json").stdout
    statistics = {each["name"]: each["value"] for each in json.loads(again)["statistics"]}
    assert statistics["walkthrough.frames"] == 2


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("walkthrough", "aila2004/simpel"), "simpel"),
        (("walkthrough", "aila2004/simple", "--set", "frames=0"), "frames"),
        (("walkthrough", "aila2004/simple", "--out", "taken"), "is not a folder"),
        (("reproduce", "johnson2004", "--frames", "1"), "'johnson2004' has no walkthroughs, so no frames"),
        (("reproduce", "aila2004", "--frames", "0"), "greater than or equal to 1"),
    ],
)
def test_what_cannot_be_done_is_refused(in_an_empty_folder, arguments, problem):
    (in_an_empty_folder / "taken").write_text("")
    assert problem in archsim_(*arguments, exit_code=2).stderr
