"""The pages in a real browser, opened from disk without a network."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from matplotlib.image import imread

from archsim.config import load_run_with_origins
from archsim.report.reproduction_page import reproduction_report
from archsim.report.run_page import run_report
from archsim.report.sweep_page import sweep_report
from archsim.reproduce.cells import Paper, Place, make_cell
from archsim.reproduce.reproduction import Reproduction, Row
from tests.run.results import CONFIG_YAML, MANIFEST, make_result
from tests.sweep.test_conduct import conducted

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), ""
)

FRAME = 100  # lines of a window, at the most, that the browser takes for itself and leaves blank


def in_browser(folder, page, *options):
    words = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        f"--user-data-dir={folder}/profile",
    ]
    command = [CHROMIUM, *words, *options, page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout


def shown(folder, html, height):
    """The page's text in the browser, after its picture was checked: something in every 100 lines."""
    page = folder / "report.html"
    page.write_text(html)

    window = f"--window-size=1250,{height + FRAME}"
    in_browser(folder, page, window, f"--screenshot={folder}/page.png")
    text = in_browser(folder, page, "--dump-dom")

    picture = imread(folder / "page.png")[:height, :, :3]
    assert picture.shape[:2] == (height, 1250)
    assert np.ptp(picture.reshape(-1, 3), axis=0).min() > 0.5
    inked = (picture.mean(axis=2) < 0.9).mean(axis=1)
    assert (inked.reshape(-1, 100).max(axis=1) > 0).all()
    assert "http://" not in text.replace("http://www.w3.org", "")
    return text


@pytest.mark.skipif(not CHROMIUM, reason="no Chromium is installed")
def test_a_run_page_opens_from_disk(tmp_path):
    assert "Speed of light" in shown(tmp_path, run_report(make_result(), CONFIG_YAML, MANIFEST, []), 1600)


@pytest.mark.skipif(not CHROMIUM, reason="no Chromium is installed")
def test_a_reproduction_page_opens_from_disk_and_its_widest_table_fits(tmp_path):
    cells = [
        make_cell(Place("paper", 1, f"row {k}", column), "predicted", 1000.5, 1100 + k, "cycles")
        for k in range(6)
        for column in ("cycles", "cycles of the other phase", "misses")
    ]
    paper = Paper("paper", "A paper", {1: "Six rows"}, {})
    row = Row(load_run_with_origins("runs/tiny.yaml"), make_result(), 1.0)
    html = reproduction_report(paper, Reproduction({"row 0": row}, cells), MANIFEST, {})
    measure = (
        "<script>document.title = document.querySelector('.scroll').scrollWidth + ' of ' + "
        "document.querySelector('.scroll').clientWidth;</script></body>"
    )

    text = shown(tmp_path, html.replace("</body>", measure), 1600)

    width, room = re.search(r"<title>(\d+) of (\d+)</title>", text).groups()
    assert int(width) <= int(room)
    assert "What limits each phase" in text


@pytest.mark.skipif(not CHROMIUM, reason="no Chromium is installed")
def test_a_sweep_page_opens_from_disk(tmp_path):
    sizes = {"grid": {"machine.components.l2.size": ["1 KiB", "3000 B", "2 KiB"]}}
    conducted(tmp_path / "sweep", parameters=[sizes], metrics=("izb_build.cycles",))

    assert "2 KiB" in shown(tmp_path, sweep_report(tmp_path / "sweep"), 900)
