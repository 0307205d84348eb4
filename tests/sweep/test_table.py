"""The table of a sweep, read by pandas and by DuckDB."""

import duckdb
import pandas as pd
import pytest

from archsim.errors import ArchsimError
from archsim.sweep.table import check_metrics, load_table, metrics_of, parameters_of, units_of, write_table
from tests.sweep.test_conduct import conducted


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    parameters = [{"grid": {"machine.components.l2.size": ["1 KiB", "3000 B", "2 KiB"], "seed": [1, 2]}}]
    conducted(folder, parameters=parameters)
    return folder


def test_a_row_a_point_with_its_parameters_and_statistics(folder):
    table = load_table(folder)

    assert list(table["machine.components.l2.size"]) == ["1 KiB"] * 2 + ["3000 B"] * 2 + ["2 KiB"] * 2
    assert list(table["status"]) == ["finished"] * 2 + ["failed"] * 2 + ["finished"] * 2
    assert table["izb_build.cycles"].notna().tolist() == [True] * 2 + [False] * 2 + [True] * 2
    assert "must be sets x ways x line" in table["error"][2]
    assert table["command"][0].startswith("archsim run runs/tiny.yaml --set")


def test_only_what_differs_is_a_parameter(folder):
    assert parameters_of(folder) == ["machine.components.l2.size", "seed"]
    assert metrics_of(folder, load_table(folder)) == [
        "izb_clear.cycles",
        "izb_build.cycles",
        "izb_raster.cycles",
    ]


def test_parquet_holds_the_same(folder):
    path = write_table(folder)

    pd.testing.assert_frame_equal(pd.read_parquet(path), load_table(folder), check_dtype=False)
    rows = duckdb.sql(
        f"""select "machine.components.l2.size" as size, min("izb_raster.cycles") as cycles
            from '{path}' where status = 'finished' group by size order by size"""
    ).fetchall()
    assert [size for size, _ in rows] == ["1 KiB", "2 KiB"]
    assert all(cycles > 0 for _, cycles in rows)


def test_points_that_were_not_tried_are_unfinished(folder, tmp_path):
    (tmp_path / "sweep.json").write_text((folder / "sweep.json").read_text())

    assert set(load_table(tmp_path)["status"]) == {"unfinished"}


def test_what_a_point_does_not_set_is_missing(tmp_path):
    """Text beside nothing stays nothing: "nan" would be a value."""
    conducted(tmp_path, parameters=[{"list": [{"workload.pixel_tile": [8, 8]}, {"workload.locks": 2}]}])
    table = load_table(tmp_path)
    assert table["workload.pixel_tile"][0] == "[8, 8]"
    assert table["workload.pixel_tile"].isna().tolist() == [False, True]
    assert table["workload.locks"].isna().tolist() == [True, False]
    assert table["workload.locks"][1] == 2
    assert str(table["workload.locks"][1]) == "2"


def test_a_metric_that_no_point_has_is_named(folder, tmp_path):
    conducted(tmp_path, metrics=("izb_buidl.cycles", "izb_raster.cycles"))
    table = load_table(tmp_path)

    assert metrics_of(tmp_path, table) == ["izb_raster.cycles"]
    with pytest.raises(ArchsimError, match=r"'izb_buidl\.cycles'; did you mean 'izb_build\.cycles'"):
        check_metrics(tmp_path, table)
    check_metrics(folder, load_table(folder))


def test_units_are_those_of_the_statistics(folder):
    assert units_of(folder)["izb_build.cycles"] == "cycles"
