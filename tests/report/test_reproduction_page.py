"""The report of a reproduction: tables with printed beside ours."""

import pytest

from archsim.config import load_run_with_origins
from archsim.config.explain import Origin
from archsim.report.reproduction_page import reproduction_report, summary
from archsim.report.tables import grade, tables
from archsim.reproduce.cells import Paper, Place, make_cell, new_cell
from archsim.reproduce.reproduction import Picture, Reproduction, Row
from tests.report.pages import check_self_contained
from tests.run.results import MANIFEST, make_result

PAPER = Paper("paper", "A paper & its title", {1: "First", 2: "Second"}, {2: ["A remark."]})
CELLS = [
    make_cell(Place("paper", 1, "a", "cycles"), "predicted", 2000, 2020, "cycles"),
    make_cell(Place("paper", 1, "b", "cycles"), "predicted", 1000, 1100, "cycles"),
    make_cell(Place("paper", 1, "a", "size"), "exact", 16, 16, "KiB"),
    make_cell(Place("paper", 2, "a", "latency"), "not comparable", [75, 118], 160, "cycles"),
    make_cell(Place("paper", 2, "a", "layers"), "calibrated", 3.43, 3.5, "layers"),
]


def test_the_page_is_whole_and_holds_the_cells():
    rows = {
        name: Row(load_run_with_origins("runs/tiny.yaml", [f"name={name}"]), make_result(), 1.0)
        for name in "ab"
    }
    links = {"a": "a/report.html"}

    page = check_self_contained(reproduction_report(PAPER, Reproduction(rows, CELLS), MANIFEST, links))

    for text in (
        "A paper & its title",
        "Table 2. Second",
        "A remark.",
        "2,020",
        "+1.0 %",
        "75 - 118",
        "--set name=a",
        "--set name=b",
        "configs/machines/tiny.yaml:",
    ):
        assert text in page.text, text
    assert page.tags.count("img") == 2  # one shadow a row


def test_a_table_that_was_never_printed_is_rows_by_columns_and_pictures_follow():
    cells = [
        new_cell(Place("paper", 1, row, column), value, "bits")
        for row, column, value in (("a", "plane", 120), ("a", "anchor", 119), ("b", "plane", 384))
    ]
    picture = Picture("What it shows.", '<svg viewBox="0 0 1 1"></svg>')

    machine = {"the machine": [Origin("clocks.core", "1 GHz", "a.yaml:3:1")]}
    reproduction = Reproduction({}, cells, (picture,), origins=machine)

    page = check_self_contained(reproduction_report(PAPER, reproduction, MANIFEST, {}))

    for text in ("plane", "119", "384", "What it shows.", "a.yaml:3:1"):
        assert text in page.text, text
    assert "printed" not in page.text[page.text.index("Table 1") : page.text.index("What it shows.")]
    assert "issue slots" not in page.text


def test_tables_are_turned_with_gaps_where_the_paper_has_none():
    first, second = tables(PAPER, CELLS)

    assert first.rows == ["a", "b"]
    assert [(line.column, line.kind) for line in first.lines] == [("cycles", "predicted"), ("size", "exact")]
    assert first.lines[1].cells == [CELLS[2], None]
    assert second.notes == ["A remark."]


def test_the_summary_counts_by_kind():
    cards = {label: value for value, label in summary(CELLS)}

    assert cards["median error of 2 predicted cells"] == "5.5 %"
    assert cards["predicted cells within 5 %"] == "1 of 2"
    assert cards["exact cells that are equal"] == "1 of 1"


@pytest.mark.parametrize(
    ("error", "expected"), [(None, "none"), (0, "good"), (-5, "good"), (5.1, "fair"), (-15.1, "poor")]
)
def test_errors_are_graded_by_size(error, expected):
    assert grade(error) == expected


def test_cells_of_several_kinds_in_a_column_get_a_line_each():
    average = make_cell(Place("paper", 2, "L2", "latency"), "predicted", [75, 118], 80, "cycles")

    (_, second) = tables(PAPER, [CELLS[3], average])

    assert [(line.kind, line.cells) for line in second.lines] == [
        ("not comparable", [CELLS[3], None]),
        ("predicted", [None, average]),
    ]
