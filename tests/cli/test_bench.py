"""The benchmark measures both phases and prints what it measured; how fast it is is not asserted."""

import json

from typer.testing import CliRunner

import archsim.cli.bench
from archsim.bench import Row, measure
from archsim.cli.app import app


def test_every_phase_is_measured():
    rows = {row.name: row for row in measure(("scene.resolution=[32, 24]",))}

    assert list(rows) == [
        "izb_build.timing",
        "izb_build.interpret",
        "izb_raster.timing",
        "izb_raster.interpret",
        "cache.replay",
        "dram.random",
        "dram.sequential",
        "pipeline.timing",
        "peak_memory",
    ]
    assert all(row.value > 0 for row in rows.values())
    assert rows["izb_build.timing"].unit == "simulated instructions/s"
    assert rows["cache.replay"].unit == "accesses/s"
    assert rows["pipeline.timing"].unit == "tasks/s"


def test_json_is_a_list_of_rows(monkeypatch):
    row = Row("izb_build.timing", 1234567, "simulated instructions/s")
    monkeypatch.setattr(archsim.cli.bench, "measure", lambda progress: [row])

    assert json.loads(CliRunner().invoke(app, ["bench", "--json"]).stdout) == [row._asdict()]
    assert "1,234,567" in CliRunner().invoke(app, ["bench"]).stdout
