"""The report of a run: one whole page with the numbers in it."""

import re

import numpy as np
import pytest

from archsim.config.explain import Origin
from archsim.report.run_page import cache_outcomes, roof_of, row_outcomes, run_report, speed_of_light
from archsim.report.statistics import Phase, phases, unit_cycles, unit_waits
from archsim.report.time_figures import latency_plot
from archsim.run.result import Check, Series, Statistic
from tests.report.pages import check_self_contained
from tests.run.results import CONFIG_YAML, MANIFEST, make_result

ORIGINS = [Origin("seed", "7", "--set seed=7")]


def page(result):
    return check_self_contained(run_report(result, CONFIG_YAML, MANIFEST, ORIGINS))


def test_the_page_is_whole_and_holds_the_numbers():
    shown = page(make_result())

    for text in (
        "made_up",
        "123,456",
        "7,654",
        "98.75",
        "71.5",
        "resolution: [4, 3]",
        "<made & up>",
        "c0de",
        "a law",
    ):
        assert text in shown.text, text
    # light, roofline, stalls, causes, caches, rows, latencies of one phase, one map, one histogram
    assert shown.tags.count("svg") == 9
    assert "4 x 3 pixels, 16.7 % in shadow" in shown.text


def test_figures_are_the_same_bytes_each_time():
    first, second = (run_report(make_result(), CONFIG_YAML, MANIFEST, ORIGINS) for _ in range(2))

    assert first == second


def test_figures_have_axes_with_units():
    shown = page(make_result())

    for label in (
        "share of issue slots [%]",
        "share of the resource's peak [%]",
        "share of lookups [%]",
        "[samples]",
    ):
        assert label in shown.text


def test_speed_of_light_takes_the_shares_of_peak():
    shares = dict(speed_of_light(phases(make_result())))

    assert shares["izb_build: issue"] == 87.25
    assert shares["izb_build: l1 ports"] == 43.5
    assert shares["izb_raster: DRAM data buses"] == 20.5


def test_outcomes_are_those_of_the_statistics():
    ran = phases(make_result())

    assert cache_outcomes(ran)["izb_raster: l2"] == {"hits": 5472, "merges": 182, "misses": 2000}
    assert row_outcomes(ran)["izb_build"] == {"row hits": 300, "row misses": 100, "row conflicts": 600}


def test_all_issue_slots_are_in_the_stack():
    (build, _) = phases(make_result())

    assert list(build.stalls()) == ["useful", "no_work", "lock", "l1", "l2", "dram"]
    assert sum(build.stalls().values()) == pytest.approx(100)


def test_failed_checks_come_first():
    shown = page(make_result(checks=[Check("holds", True, "1 = 1"), Check("broken law", False, "1 = 2")]))

    assert "1 checks failed" in shown.text
    assert shown.text.index("broken law") < shown.text.index("Speed of light")


@pytest.mark.parametrize("image", [np.full((3, 4), np.nan, np.float32), np.full((3, 4), 3, np.float32)])
def test_empty_and_constant_pictures_can_be_drawn(image):
    empty = make_result(shadow=np.zeros((1, 1), np.bool_), maps={"Nothing": image}, histograms=[])

    assert "Nothing" in page(empty).text


def test_a_run_without_phases_still_has_a_page():
    assert "made_up" in page(make_result(statistics=[])).text


def test_a_phase_stands_under_its_roofs():
    """Half of the slots used by one core; half of 16 bytes a cycle moved."""
    values = {"instructions": 50, "cycles": 100, "useful_percent": 50.0, "dram.bytes": 800}
    values |= {"dram.bandwidth_bytes_per_cycle": 8.0, "dram.bus_percent": 50.0}

    assert roof_of(Phase("p", values, [])) == (50 / 800, 0.5, 1.0, 16.0)
    assert roof_of(Phase("p", {**values, "dram.bytes": 0}, [])) is None


def test_the_page_says_who_set_each_value():
    assert "--set seed=7" in page(make_result()).text


def test_advice_is_beside_the_speed_of_light():
    assert "Limited by issue: 87 %" in page(make_result()).text


def test_a_pipelines_units_show_what_they_waited_for():
    values = {
        "busy_percent": 60.0,
        "stall.no_work_percent": 10.0,
        "stall.memory_percent": 30.0,
        "stall.dram_percent": 30.0,
        "stall.dram.queue_percent": 12.0,
        "stall.dram.bus_percent": 18.0,
    }
    result = make_result(
        statistics=[
            Statistic(f"volumes.stage_1.{name}", value, "%", "It is.") for name, value in values.items()
        ]
    )

    waits = {"no_work": 10.0, "dram.queue": 12.0, "dram.bus": 18.0}
    assert unit_waits(result) == {"volumes": {"stage_1": waits}}
    assert unit_cycles(result) == {"volumes": {"stage_1": {"busy": 60.0, "no_work": 10.0, "dram": 30.0}}}


def test_units_and_fifos_are_bands_over_time():
    columns = {
        "until_cycle": [500.0, 1000.0, 1210.0],
        "dram.bandwidth_bytes_per_cycle": [1.5, 2.5, 0.5],
        "stage_1.busy_percent": [10.0, 100.0, 0.0],
        "stage_2.busy_percent": [0.0, 50.0, 30.0],
        "held.fill_percent": [0.0, 99.0, 1.0],
    }
    shown = page(make_result(series={"shadow_volumes": Series(500, columns)}))

    for text in (
        "Over time",
        "shadow volumes",
        "in intervals of 500",
        "stage 1",
        "stage 2",
        "busy percent",
        "held",
    ):
        assert text in shown.text, text
    pictures = [load for load in shown.loads if load.startswith("data:image/png")]
    assert len(pictures) >= len(("busy", "fill"))


def test_a_heat_maps_unit_is_on_its_colour_bar_and_a_slivers_title_is_whole():
    sliver = make_result(maps={"map_left: depth, y' upwards [0 nearest]": np.ones((400, 20), np.float32)})

    shown = page(sliver)

    assert "[fragments]" in page(make_result()).text
    assert "map_left: depth, y' upwards" in shown.text
    assert "[0 nearest]" in shown.text


def test_requests_that_were_answered_stay_answered():
    """The line ends at its top: where the last request was answered nothing falls back to none."""
    figure = latency_plot("izb build", {"l1": np.bincount([1, 1, 20], minlength=128)}, "key")

    line, _legend = re.findall(r'<path d="([^"]*)"[^>]*stroke: #56b4e9; stroke-width: 1.4', figure)
    heights = [float(point.split()[1]) for point in re.findall(r"[ML] ([\d. ]+)", line)]
    assert heights[-1] == min(heights) < max(heights)
