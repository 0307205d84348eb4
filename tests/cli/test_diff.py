"""`archsim diff` and `archsim report` on stored runs."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from archsim.cli.app import app
from archsim.run.folder import RunFiles, write_run
from tests.run.results import CONFIG_YAML, MANIFEST, make_result


@pytest.fixture(autouse=True)
def runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    other = [
        s._replace(value=s.value * 2) if s.name == "izb_build.cycles" else s for s in make_result().statistics
    ]
    for name, result in {"a": make_result(), "b": make_result(statistics=other)}.items():
        write_run(Path(name), RunFiles(result, CONFIG_YAML, MANIFEST, "<html></html>"))


def archsim_(*arguments, exit_code=0):
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == exit_code, result.output
    return result


def test_equal_results_end_with_0():
    assert archsim_("diff", "a", "a").stdout == "the results are equal\n"


def test_different_results_end_with_1_and_say_what():
    out = archsim_("diff", "a", "b", exit_code=1).stdout

    assert "izb_build.cycles" in out
    assert "+100 %" in out
    assert "izb_build.cycles [units]" in out
    archsim_("diff", "a", "b", "--tolerance", "100")


def test_differences_with_their_images_on_a_page():
    out = archsim_("diff", "a", "b", "--out", "page.html", exit_code=1).stdout

    assert out.endswith("written to page.html\n")
    assert Path("page.html").read_text().count("data:image/png") == 2


def test_differences_as_json():
    tree = json.loads(archsim_("diff", "a", "b", "--json", exit_code=1).stdout)

    assert [change["name"] for change in tree["statistics"]] == ["izb_build.cycles"]


def test_runs_side_by_side_on_a_page():
    assert "written to page.html" in archsim_("report", "a", "b", "--out", "page.html").stdout
    assert "izb_build.cycles" in Path("page.html").read_text()
    assert "name several runs" in archsim_("report", "a", exit_code=2).stderr
    assert "no such run folder" in archsim_("report", "a", "nowhere", exit_code=2).stderr
