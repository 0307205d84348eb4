"""The pages in a real browser, opened from disk without a network."""

import shutil
import subprocess

import numpy as np
import pytest
from matplotlib.image import imread

from archsim.report.run_page import run_report
from tests.run.results import CONFIG_YAML, MANIFEST, make_result

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), ""
)


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


@pytest.mark.skipif(not CHROMIUM, reason="no Chromium is installed")
def test_a_run_page_opens_from_disk(tmp_path):
    page = tmp_path / "report.html"
    page.write_text(run_report(make_result(), CONFIG_YAML, MANIFEST))

    in_browser(tmp_path, page, "--window-size=1250,1600", f"--screenshot={tmp_path}/page.png")
    shown = in_browser(tmp_path, page, "--dump-dom")

    picture = imread(tmp_path / "page.png")[..., :3]
    assert picture.shape[:2] == (1600, 1250)
    assert np.ptp(picture.reshape(-1, 3), axis=0).min() > 0.5
    inked = (picture.mean(axis=2) < 0.9).mean(axis=1)
    assert (inked.reshape(16, 100).max(axis=1) > 0).all()  # something in every 100 lines
    assert "Speed of light" in shown
    assert "http://" not in shown.replace("http://www.w3.org", "")
