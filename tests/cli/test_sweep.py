"""`archsim sweep` and what is asked of its folder."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from archsim.cli.app import app
from archsim.config.document import dump
from archsim.sweep.job import Done
from tests.sweep.small import SWEEP, InlineWorkers


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.yaml").write_text(dump(SWEEP))


@pytest.fixture
def inline(monkeypatch):
    """Jobs are done in this process."""
    monkeypatch.setattr("archsim.cli.sweep.LocalWorkers", InlineWorkers)


def archsim_(*arguments, exit_code=0):
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == exit_code, result.output
    return result


def test_a_sweep_leaves_a_table_and_asks_nothing_twice(inline):
    assert "4 points finished, 0 failed" in archsim_("sweep", "small.yaml", "--out", "out").stdout
    again = archsim_("sweep", "run", "small.yaml", "--out", "out").stdout
    assert "0 points finished, 0 failed, 4 were finished before" in again

    lines = archsim_("sweep", "table", "out", "--format", "csv").stdout.splitlines()
    assert len(lines) == 5
    assert lines[0].startswith("point,scene.resolution,machine.components.l2.size,")
    assert archsim_("sweep", "table", "out", "--format", "parquet").stdout.strip() == "out/table.parquet"
    assert "finished" in archsim_("sweep", "table", "out").stdout
    assert "knee" in archsim_("sweep", "pareto", "out", "--minimize", "izb_build.cycles").stdout
    assert "l2.size" in archsim_("sweep", "sensitivity", "out", "--of", "izb_raster.cycles").stdout


def test_shards_share_a_folder(inline):
    for part in ("1/2", "2/2"):
        assert "2 points finished" in archsim_("sweep", "small.yaml", "--out", "out", "--shard", part).stdout

    assert "4 were finished before" in archsim_("sweep", "small.yaml", "--out", "out").stdout


def test_failures_end_with_1_and_say_where_they_are(monkeypatch):
    monkeypatch.setattr(
        "archsim.cli.sweep.LocalWorkers",
        lambda jobs: InlineWorkers(do=lambda job: Done(0.0, "no memory")),
    )

    result = archsim_("sweep", "small.yaml", exit_code=1)

    assert "0 points finished, 4 failed" in result.stdout
    assert "runs/sweep-small/failed" in result.stderr


def test_a_dry_run_prints_the_points_and_does_nothing(tmp_path):
    result = archsim_("sweep", "small.yaml", "--dry-run")

    assert len(result.stdout.splitlines()) == 4
    assert "4 of 4 points, 2 pictures to render" in result.stderr
    assert "pictures and their work take from the machine: nothing" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["small.yaml"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["tinny"], "did you mean 'tiny'"),
        (["small.yaml", "--shard", "3/2"], "a shard is written I/N"),
        (["small.yaml", "--out", "small.yaml"], "small.yaml: is not a folder"),
        (["table", "nowhere"], "nowhere: is not a sweep"),
        (["table", "."], "is not a sweep"),
    ],
)
def test_bad_input_ends_with_2(arguments, message):
    result = archsim_("sweep", *arguments, exit_code=2)

    assert message in result.stderr
    assert "Traceback" not in result.output


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "text").touch()

    assert (
        "something else than a sweep"
        in archsim_("sweep", "small.yaml", "--out", "thesis", exit_code=2).stderr
    )


def test_points_that_all_failed_have_no_front(inline):
    sizes = [{"grid": {"machine.components.l2.size": ["3000 B", "3001 B"]}}]
    Path("bad.yaml").write_text(dump({**SWEEP, "parameters": sizes}))
    archsim_("sweep", "bad.yaml", "--out", "out", exit_code=1)

    for verb in ("pareto", "sensitivity"):
        assert archsim_("sweep", verb, "out", exit_code=2).stderr == "out: no point has a result\n"
    assert "failed" in archsim_("sweep", "table", "out").stdout


def test_a_misspelt_metric_costs_no_point_and_no_page(inline):
    Path("bad.yaml").write_text(dump({**SWEEP, "metrics": ["izb_buidl.cycles"]}))

    result = archsim_("sweep", "bad.yaml", "--out", "out", exit_code=2)

    assert "4 points finished" in result.stdout
    assert "did you mean 'izb_build.cycles'" in result.stderr
    assert Path("out/report.html").is_file()
    assert "finished" in archsim_("sweep", "table", "out").stdout


def test_a_row_of_a_table_stays_on_its_line(inline):
    archsim_("sweep", "small.yaml", "--out", "out")

    lines = [line for line in archsim_("sweep", "table", "out").stdout.splitlines() if "finished" in line]
    assert len(lines) == 4
    assert all("KiB" in line for line in lines)


def test_a_sweep_starts_from_a_packaged_run_by_its_name():
    Path("named.yaml").write_text(dump({**SWEEP, "run": "tiny"}))
    Path("misnamed.yaml").write_text(dump({**SWEEP, "run": "runs/tinny.yaml"}))

    assert "archsim run runs/tiny.yaml" in archsim_("sweep", "named.yaml", "--dry-run").stdout
    for verb in (["sweep"], ["config", "check"]):
        stderr = archsim_(*verb, "misnamed.yaml", exit_code=2).stderr
        assert stderr == (
            "misnamed.yaml:2:6: no such file: 'runs/tinny.yaml'; did you mean 'runs/tiny.yaml'?\n"
        )


def test_packaged_sweeps_are_found_from_everywhere():
    assert "archsim run runs/tiny.yaml" in archsim_("sweep", "tiny", "--dry-run").stdout


def test_whatif_ranks_the_ideal_parts(inline):
    arguments = ["whatif", "tiny", "--set", "scene.resolution=[16, 12]", "--no-pairs", "--out", "out"]

    lines = [line.strip() for line in archsim_(*arguments).stdout.splitlines()]

    ranked = [line for line in lines if "." in line and not line.startswith("written")]
    assert any(line.startswith("the machine as it is") and " 1.000 " in line for line in ranked)
    assert ranked[0].startswith("perfect L")
    assert json.loads(archsim_(*arguments, "--json").stdout)[0]["speedup"] > 1
