"""What differs between two runs, by hand."""

import math

import numpy as np
import pytest

from archsim.report.comparison_page import comparison_report
from archsim.report.differences import ConfigChange, config_changes, differences, relative_percent
from archsim.run.folder import StoredRun
from archsim.run.result import Check, Statistic
from tests.report.pages import check_self_contained
from tests.run.results import CONFIG_YAML, MANIFEST, make_result


def stored(config=CONFIG_YAML, name="a", **changes) -> StoredRun:
    from pathlib import Path

    return StoredRun(Path(name), make_result(name=name, **changes), config, MANIFEST)


def statistics(**values):
    return [Statistic(name, value, "cycles", "What it is.") for name, value in values.items()]


def test_equal_runs_have_no_differences():
    found = differences(stored(), stored(name="b"))

    assert found == ([], [], [], 0)
    assert not found.matter()


def test_statistics_are_sorted_by_relative_change():
    left = stored(statistics=statistics(same=1, small=100, large=10, gone=5, zero=0))
    right = stored(statistics=statistics(same=1, small=101, large=5, new=5, zero=2))

    found = differences(left, right).statistics

    assert [(change.name, change.percent) for change in found] == [
        ("gone", math.inf),
        ("zero", math.inf),
        ("new", math.inf),
        ("large", -50),
        ("small", 1),
    ]


def test_small_changes_can_be_tolerated():
    found = differences(stored(statistics=statistics(a=100)), stored(statistics=statistics(a=101)))

    assert found.matter()
    assert not found.matter(tolerance_percent=1)


def test_what_is_not_a_number_equals_itself():
    assert relative_percent(math.nan, math.nan) == 0
    assert relative_percent(-10, -5) == 50


def test_configurations_are_compared_key_by_key():
    left = "a: {b: 1, c: [1, 2]}\nlights:\n- {x: 1}\n"
    right = "a: {b: 2, c: [1, 3], d: null}\nlights:\n- {x: 1}\n- {x: 2}\n"

    assert config_changes(left, right) == [
        ConfigChange("a.b", 1, 2),
        ConfigChange("a.c", [1, 2], [1, 3]),
        ConfigChange("a.d", "-", None),
        ConfigChange("lights.1.x", "-", 2),
    ]


def test_a_configuration_without_effect_does_not_matter():
    found = differences(stored(), stored(CONFIG_YAML + "more: 1\n"))

    assert [change.key for change in found.config] == ["more"]
    assert not found.matter()


def test_checks_and_pixels_matter():
    mask = make_result().shadow.copy()
    mask[0, 0] = True

    assert differences(stored(), stored(checks=[Check("a law", False, "")])).checks == [
        ("a law", True, False)
    ]
    assert differences(stored(), stored(shadow=mask)).num_pixels == 1
    assert differences(stored(), stored(shadow=mask)).matter()
    assert differences(stored(), stored(shadow=mask[1:])).num_pixels is None


@pytest.mark.parametrize("count", [2, 3])
def test_the_page_compares_all_runs_with_the_first(count):
    mask = ~make_result().shadow
    runs = [stored()] + [
        stored("name: x\n", name=f"run{k}", shadow=mask, statistics=statistics(only_here=k))
        for k in range(1, count)
    ]

    page = check_self_contained(comparison_report(runs))

    assert "only_here" in page.text
    assert "12 pixels differ from a" in page.text
    assert "scene.resolution" in page.text
    assert page.tags.count("img") == 1 + 2 * (count - 1)


def test_points_of_sweeps_without_pictures_can_be_compared():
    empty = np.zeros((0, 0), np.bool_)

    page = check_self_contained(comparison_report([stored(shadow=empty), stored(name="b", shadow=empty)]))

    assert "img" not in page.tags
