"""The page of a sweep."""

import pytest

from archsim.report.sweep_page import sweep_report
from archsim.sweep.table import load_table
from tests.report.pages import check_self_contained
from tests.sweep.test_conduct import conducted


@pytest.mark.parametrize("metrics", [(), ("izb_build.cycles", "machine.components.l2.size")])
def test_the_page_holds_points_front_effects_and_failures(tmp_path, metrics):
    sizes = {"grid": {"machine.components.l2.size": ["1 KiB", "3000 B", "2 KiB"], "seed": [1, 2]}}
    conducted(tmp_path, parameters=[sizes], metrics=metrics)

    page = check_self_contained(sweep_report(tmp_path))

    assert "2 points failed" in page.text
    assert "must be sets x ways x line" in page.text
    assert "Pareto front" in page.text
    assert "What moves izb_build.cycles" in page.text
    assert f"{load_table(tmp_path)['izb_build.cycles'].min():,.0f} cycles" in " ".join(page.text.split())
    assert "izb build: cycles, the least" in page.text
    assert "izb_build.cycles [cycles]" in page.text
    assert "archsim run runs/tiny.yaml" in page.text
    assert "code digest" in page.text
    assert "1 KiB, 3000 B, 2 KiB" in page.text
    assert "configs/machines/tiny.yaml:" in page.text


def test_a_sweep_without_results_has_a_page(tmp_path):
    bad = {"grid": {"machine.components.l2.size": ["3000 B", "3001 B"]}}
    conducted(tmp_path, parameters=[bad])

    assert "2 points failed" in check_self_contained(sweep_report(tmp_path)).text
