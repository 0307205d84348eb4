"""The verbs of the command line for Python, with frames and HTML for notebooks."""

import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

import archsim
from archsim.errors import ArchsimError
from archsim.reproduce.cells import Place, make_cell
from archsim.reproduce.johnson2004 import Reproduction
from tests.sweep.small import SWEEP

SMALL = {"scene.resolution": [16, 12]}


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_the_verbs_are_there_without_loading_anything_slow():
    code = (
        "import archsim, sys; print(sorted(set(archsim.__all__) - set(dir(archsim))), 'numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout == "[] False\n"
    assert all(callable(getattr(archsim, name)) for name in archsim.__all__)
    with pytest.raises(AttributeError, match="swep"):
        archsim.swep  # noqa: B018


def test_packages_with_the_names_of_verbs_stay_packages():
    import archsim.sweep.table

    assert archsim.sweep.table.load_table
    assert callable(archsim.sweep)


def test_a_run_is_loaded_and_simulated():
    loaded = archsim.load("tiny", {**SMALL, "machine.components.l2.size": "2 KiB"})

    run = archsim.simulate(loaded)

    assert loaded.config.scene.resolution == (16, 12)
    assert run["izb_build.cycles"] == run.frame().loc["izb_build.cycles", "value"] > 0
    assert "izb_build.cycles" in run._repr_html_()
    assert archsim.simulate("tiny", ["scene.resolution=[16, 12]"]).result.ok
    with pytest.raises(ArchsimError, match="did you mean 'tiny'"):
        archsim.load("tinny")
    with pytest.raises(ArchsimError, match="a loaded configuration takes no changes"):
        archsim.simulate(loaded, SMALL)


def test_a_runs_page_says_who_set_each_value():
    loaded = archsim.load("tiny", SMALL)
    in_python = loaded.config.model_copy(update={"seed": 7})

    page = archsim.report(archsim.simulate(loaded), "run.html").read_text()
    other = archsim.report(archsim.simulate(in_python), "python.html").read_text()

    assert "configs/machines/tiny.yaml:" in page
    assert "--set scene.resolution=[16, 12]" in page
    assert "<td>Python</td>" not in page
    assert "<td>Python</td>" in other
    assert "configs/machines/tiny.yaml:" not in other


def test_a_sweep_gives_a_table_and_its_answers():
    swept = archsim.sweep(SWEEP, out="out")

    assert len(swept.table) == len(swept.points()) == 4
    assert isinstance(swept.pareto("izb_build.cycles"), pd.DataFrame)
    assert swept.sensitivity("izb_build.cycles")["parameter"][0]
    assert "1 KiB" in swept._repr_html_()
    assert archsim.sweep(SWEEP, out="out").table.equals(swept.table)
    with pytest.raises(ArchsimError, match="unknown key 'metric'; did you mean 'metrics'"):
        archsim.sweep({**SWEEP, "metric": ["izb_build.cycles"]})


def test_pages_are_written_for_runs_and_sweeps():
    swept = archsim.sweep(SWEEP, out="out")
    points = sorted(Path("out/points").iterdir())

    pages = [
        archsim.report(archsim.simulate("tiny", SMALL), "run.html"),
        archsim.report(swept, "sweep.html"),
        archsim.report(["out"], "again.html"),
        archsim.report("out", "once_more.html"),
        archsim.report(points[:2], "points.html"),
    ]

    assert all("</html>" in page.read_text() for page in pages)


def test_a_reproduction_has_its_cells_as_a_frame(monkeypatch):
    cells = [
        make_cell(Place("johnson2004", 3, "doom_light0", "cycles"), "predicted", 26107800, 26000000, "cycles")
    ]
    monkeypatch.setattr("archsim.reproduce.johnson2004.reproduce", lambda progress: Reproduction({}, cells))

    found = archsim.reproduce("johnson2004")

    assert found.frame()["ours"].tolist() == [26000000]
    assert "26000000" in found._repr_html_()
    assert "26,107,800" in archsim.report(found, "paper.html").read_text()
    with pytest.raises(ArchsimError, match="did you mean 'johnson2004'"):
        archsim.reproduce("jonson2004")
