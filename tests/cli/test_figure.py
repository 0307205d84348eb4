"""`archsim reproduce PAPER --figure NUMBER` on a small scene."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from archsim.cli.app import app
from archsim.reproduce import johnson2004_figure8
from archsim.shadow.map_quality import Point

POINTS = [Point("irregular", 640, 0.0), Point("nearest texel", 64, 0.25), Point("nearest texel", 256, 0.125)]


@pytest.fixture
def run(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(johnson2004_figure8, "reproduce", lambda progress: POINTS)
    return lambda *arguments: CliRunner().invoke(app, ["reproduce", "johnson2004", *arguments])


def test_the_figure_is_printed_and_kept(run, tmp_path):
    done = run("--figure", "8")
    assert done.exit_code == 0
    assert "nearest texel" in done.output
    folder = tmp_path / "runs" / "reproduce-johnson2004-figure8"
    assert json.loads((folder / "points.json").read_text())[1] == POINTS[1]._asdict()
    assert "<svg" in (folder / "figure.svg").read_text()


def test_json_is_all_that_is_printed(run):
    assert json.loads(run("--figure", "8", "--json").stdout) == [point._asdict() for point in POINTS]


def test_other_figures_are_not_there(run):
    done = run("--figure", "7")
    assert done.exit_code == 2
    assert "no figure 7 of 'johnson2004'; there are: johnson2004 --figure 8" in done.output
