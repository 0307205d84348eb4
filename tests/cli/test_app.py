"""The command line: output, errors and exit codes. What it runs is replaced by something that takes no time."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import archsim.cli.run
from archsim.cli.app import app
from archsim.config import load_run, load_run_with_origins
from archsim.reproduce import johnson2004
from archsim.reproduce.cells import Place, make_cell
from archsim.reproduce.johnson2004 import simulate_row
from archsim.reproduce.reproduction import Reproduction, Row
from archsim.run.folder import load_folder, result_json
from archsim.run.result import Check
from tests.run.results import make_result


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def simulated(monkeypatch):
    """Configurations that were simulated; every run has the made-up result."""
    seen = []

    def simulate(config, progress):
        seen.append(config)
        progress("izb_build", 1, 2)
        return make_result()

    monkeypatch.setattr(archsim.cli.run, "simulate", simulate)
    return seen


def archsim_(*arguments, exit_code=0):
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == exit_code, result.output
    return result


def test_a_run_leaves_a_folder_and_says_where(simulated):
    Path("tiny").mkdir()  # a folder of that name doesn't hide the packaged run

    result = archsim_("run", "tiny")

    assert load_folder(Path("runs/made_up")).manifest["seed"] == 0
    assert "123,456" in result.stdout
    assert "runs/made_up" in result.stdout
    assert [config.model for config in simulated] == ["compiled"]


@pytest.mark.parametrize("name", ["tiny", "runs/tiny.yaml", "configs/runs/tiny.yaml"])
def test_packaged_runs_are_found_from_everywhere(simulated, name):
    archsim_("run", name)

    assert [config.name for config in simulated] == ["tiny"]


def test_a_finished_run_is_run_again_by_its_folder(simulated):
    archsim_("run", "tiny", "--set", "seed=7", "--out", "there/tiny")
    archsim_("run", "there/tiny", "--out", "again")

    assert [config.seed for config in simulated] == [7, 7]


def test_a_bare_folder_is_a_run_unless_a_packaged_one_has_its_name(simulated):
    archsim_("run", "tiny", "--set", "seed=7", "--out", "mine")
    Path("tiny").mkdir()
    Path("tiny/config.yaml").write_text(Path("mine/config.yaml").read_text())

    archsim_("run", "mine")
    archsim_("run", "tiny")

    assert [config.seed for config in simulated] == [7, 7, 0]


def test_json_is_the_only_output(simulated):
    result = archsim_("run", "tiny", "--json", "--out", "there")

    assert result.stdout == result_json(make_result())
    assert result.stderr == ""
    assert load_folder(Path("there")).result.name == "made_up"


def test_overrides_and_the_model_reach_the_run(simulated):
    archsim_("run", "tiny", "--set", "scene.resolution=[8, 6]", "--set", "name=other", "--model", "reference")

    (config,) = simulated
    assert (config.name, config.scene.resolution, config.model) == ("other", (8, 6), "reference")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["tinny"], "did you mean 'tiny'?"),
        (["nowhere.yaml"], "nowhere.yaml"),
        (["tiny", "--model", "compield"], "model"),
        (["tiny", "--set", "scene.resolutoin=[8, 6]"], "resolution"),
        (["tiny", "--out", "occupied"], "occupied: holds something else than an archsim run"),
    ],
)
def test_bad_input_ends_with_2_and_its_name_and_no_folder(simulated, tmp_path, arguments, message):
    (tmp_path / "occupied").mkdir()
    (tmp_path / "occupied" / "file").touch()

    result = archsim_("run", *arguments, exit_code=2)

    assert message in result.stderr
    assert "Traceback" not in result.output
    assert result.stdout == ""
    assert simulated == []
    assert [path.name for path in tmp_path.iterdir()] == ["occupied"]


def test_every_problem_has_its_line(tmp_path):
    (tmp_path / "bad.yaml").write_text("base: runs/tiny.yaml\nnmae: x\nmodel: fast\n")

    lines = archsim_("config", "check", "bad.yaml", exit_code=2).stderr.splitlines()

    assert [line.split(" ")[0] for line in lines] == ["bad.yaml:2:1:", "bad.yaml:3:8:"]


def test_a_broken_law_ends_with_1_and_is_kept(monkeypatch):
    broken = make_result(checks=[Check("books balance", False, "1 = 2")])
    monkeypatch.setattr(archsim.cli.run, "simulate", lambda config, progress: broken)

    result = archsim_("run", "tiny", "--json", exit_code=1)

    assert "made_up: check failed: books balance: 1 = 2" in result.stderr
    assert not load_folder(Path("runs/made_up")).result.ok


def test_an_interrupted_run_ends_with_130_and_no_folder(monkeypatch, tmp_path):
    def simulate(config, progress):
        raise KeyboardInterrupt

    monkeypatch.setattr(archsim.cli.run, "simulate", simulate)

    assert archsim_("run", "tiny", exit_code=130).stderr == "interrupted\n"
    assert list(tmp_path.iterdir()) == []


def test_the_shown_configuration_runs_again(simulated, tmp_path):
    shown = archsim_("config", "show", "tiny", "--set", "seed=7").stdout
    (tmp_path / "shown.yaml").write_text(shown)

    assert load_run("shown.yaml").seed == 7
    assert archsim_("config", "show", "shown.yaml").stdout == shown
    assert archsim_("config", "check", "tiny", "shown.yaml").stdout == "tiny: ok\nshown.yaml: ok\n"


def test_the_listing_counts_instructions_and_registers():
    listing = archsim_("asm", "izb_build").stdout

    assert "izb_build: 40 instructions" in listing
    assert "live registers" in listing.splitlines()[-1]


def test_canonical_text_assembles_to_itself(tmp_path):
    canonical = archsim_("disasm", "izb_raster").stdout
    (tmp_path / "again.s").write_text(canonical)

    assert archsim_("disasm", "again.s").stdout == canonical


def test_errors_in_assembly_have_file_line_and_column(tmp_path):
    (tmp_path / "bad.s").write_text("!!VP2.0\nMUV R0, v[0];\nEND\n")

    for verb in ("asm", "disasm"):
        result = archsim_(verb, "bad.s", exit_code=2)
        assert result.stderr.startswith("bad.s:2:1: ")
        assert result.stdout == ""
    assert "no_such" in archsim_("asm", "no_such", exit_code=2).stderr


@pytest.fixture
def reproduced(monkeypatch):
    row = Row(load_run_with_origins("runs/tiny.yaml"), make_result(), 1.5)
    cells = [
        make_cell(Place("johnson2004", 3, "doom_light0", "cycles"), "predicted", 26107800, 26000000, "cycles")
    ]
    reproduction = Reproduction({"doom_light0": row}, cells)
    monkeypatch.setattr(johnson2004, "reproduce", lambda progress: reproduction)
    return reproduction


def test_a_reproduction_prints_its_cells_and_leaves_its_rows(reproduced, tmp_path):
    result = archsim_("reproduce")

    for text in ("26,107,800", "26,000,000", "-0.4 %", "predicted", "runs/reproduce-johnson2004"):
        assert text in result.stdout
    folder = tmp_path / "runs" / "reproduce-johnson2004"
    assert load_folder(folder / "doom_light0").result.name == "made_up"
    assert "26,107,800" in (folder / "report.html").read_text()
    for page in (folder / "report.html", folder / "doom_light0" / "report.html"):
        assert "configs/machines/tiny.yaml:" in page.read_text()
    archsim_("reproduce")  # replaces it
    assert [path.name for path in folder.parent.iterdir()] == ["reproduce-johnson2004"]


def test_a_reproduction_as_json_is_a_list_of_cells(reproduced):
    result = archsim_("reproduce", "johnson2004", "--json", "--out", "there")

    assert json.loads(result.stdout) == [cell._asdict() for cell in reproduced.cells]
    assert result.stderr == ""


@pytest.mark.parametrize("width", [80, 200])
def test_tables_fit_the_terminal(reproduced, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))

    lines = archsim_("reproduce").stdout.splitlines()

    assert max(len(line) for line in lines if "written to" not in line) <= width
    assert any("26,107,800" in line and "26,000,000" in line and "-0.4 %" in line for line in lines)


def test_an_unknown_paper_is_named():
    assert "did you mean 'johnson2004'?" in archsim_("reproduce", "jonson2004", exit_code=2).stderr


def test_the_version_is_printed():
    assert archsim_("--version").stdout == "archsim 0.1.0\n"


def test_rows_tell_their_progress_by_name(monkeypatch):
    told = []
    monkeypatch.setattr(
        "archsim.reproduce.johnson2004.simulate", lambda config, progress: progress("build", 1, 2)
    )

    simulate_row("knot_light0", lambda *report: told.append(report))

    assert told == [("knot_light0 build", 1, 2)]


def test_a_key_is_explained_with_the_place_that_set_it():
    lines = archsim_("config", "explain", "seed", "tiny", "--set", "seed=3").stdout.splitlines()

    assert lines[0] == "seed"
    assert lines[-1].split("set by")[1].strip() == "--set seed=3"


def test_the_schema_is_json():
    assert json.loads(archsim_("config", "schema", "machine").stdout)["title"] == "MachineConfig"
