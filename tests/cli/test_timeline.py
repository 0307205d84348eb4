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


def test_cycles_of_every_phase_are_recorded(tmp_path):
    out = archsim_("tiny", "--set", "scene.resolution=[16, 12]", "--cycles", "100:200").stdout

    assert [line.split()[2] for line in out.splitlines()] == [
        f"timeline-{phase}.json" for phase in ("izb_clear", "izb_build", "izb_raster")
    ]


FEW = ["--set", "scene.resolution=[16, 16]", "--set", "scene.mesh.parameters.knights=2"]
HSV = ["hsv_knights_hierarchical", *FEW]


def test_a_pipeline_has_a_timeline_of_its_units(tmp_path):
    out = archsim_(*HSV, "--cycles", "300", "--waterfall", "100").stdout

    lines = out.splitlines()
    assert lines[0] == "cycles 0 to 99"
    assert any(line.startswith("geometry") for line in lines)
    events = json.loads((tmp_path / "timeline.json").read_text())["traceEvents"]
    names = {event["args"]["name"] for event in events if event["ph"] == "M"}
    assert {"geometry", "psv_cache (cache 0)"} & names
    assert {"busy", "no work"} & {event["name"] for event in events if event["ph"] == "X"}
    assert "<svg" in (tmp_path / "timeline.svg").read_text()


def test_tasks_of_a_unit_are_recorded_while_they_are_done(tmp_path):
    out = archsim_(*HSV, "--tasks", "2:4", "--unit", "geometry").stdout

    first, last = (int(word) for word in out.splitlines()[0].split()[2::2])
    assert out.startswith("shadow_volumes: cycles ")
    events = json.loads((tmp_path / "timeline.json").read_text())["traceEvents"]
    names = {event["name"] for event in events if event["ph"] == "X" and event["name"].startswith("task ")}
    assert {"task 2", "task 3"} <= names
    assert 0 < first < last


def test_a_fifo_before_cores_has_a_track(tmp_path):
    slow = ["--set", "machine.components.rasterizer.interval_cycles=20"]
    archsim_("tiny", "--set", "scene.resolution=[16, 12]", *slow, "--cycles", "500", "--phase", "izb_raster")

    events = json.loads((tmp_path / "timeline.json").read_text())["traceEvents"]
    assert {"fragments"} == {event["name"] for event in events if "held" in event.get("args", {})}


def test_a_run_leaves_its_timelines_and_is_the_same_run(tmp_path):
    small = ["run", "tiny", "--set", "scene.resolution=[16, 12]", "--json"]
    plain, recorded = (
        CliRunner().invoke(app, [*small, "--out", name, *more])
        for name, more in (("a", []), ("b", ["--timeline", "50:150"]))
    )

    assert plain.stdout == recorded.stdout
    for phase in ("izb_clear", "izb_build", "izb_raster"):
        assert json.loads((tmp_path / "b" / f"timeline-{phase}.json").read_text())["traceEvents"]
        assert (tmp_path / "b" / f"waterfall-{phase}.txt").read_text().startswith("cycles 50 to 149\n")
        assert "<svg" in (tmp_path / "b" / f"waterfall-{phase}.svg").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--phase", "izb_rastr"], "did you mean 'izb_raster'"),
        (
            ["--cycles", "9", "--phase", "izb_rastr"],
            "no phase is named 'izb_rastr'; did you mean 'izb_raster'",
        ),
        (["--cycles", "9", "--tasks", "9"], "one of them"),
        (["--tasks", "5:2"], "a range is written FIRST:LAST"),
        (["--tasks", "99999:100000"], "none of them from 99999 on"),
        (["--tasks", "5", "--unit", "rasterizer"], "irregular shadow mapping has no units"),
    ],
)
def test_bad_input_ends_with_2(arguments, message):
    assert message in archsim_("tiny", "--set", "scene.resolution=[16, 12]", *arguments, exit_code=2).stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--unit", "geometry"], "--unit: name its tasks, too (--tasks)"),
        (["--tasks", "3", "--unit", "geometri"], "no unit 'geometri'; did you mean 'geometry'"),
        (["--tasks", "999999:1000000", "--unit", "geometry"], "none of them from 999999 on"),
    ],
)
def test_bad_tasks_of_a_pipeline_end_with_2(arguments, message):
    assert message in archsim_(*HSV, *arguments, exit_code=2).stderr
