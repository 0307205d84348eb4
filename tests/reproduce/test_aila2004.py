"""Table 1 of Aila and Akenine-Moller 2004 made of made-up results; the full size is the slow test."""

from pathlib import Path

import pytest
import yaml

from archsim import resources
from archsim.config import load_walkthrough, load_walkthrough_with_origins
from archsim.reproduce import aila2004
from archsim.reproduce.aila2004 import QUANTITIES, ROWS, VARIANTS, make_cells
from archsim.reproduce.reproduction import Row
from archsim.run.result import Statistic
from tests.run.results import make_result

PRINTED = yaml.safe_load((resources.experiment("aila2004") / "printed.yaml").read_text())


def made_up_row(name):
    """A row whose statistics are 1000, 1001, 1002 ..."""
    names = [
        "walkthrough.triangles",
        *(f"{v}.{q}" for v in VARIANTS.values() for q, _, _ in QUANTITIES.values()),
    ]
    statistics = [Statistic(each, 1000 + k, "", "") for k, each in enumerate(names)]
    loaded = load_walkthrough_with_origins(resources.experiment("aila2004") / f"{name}.yaml")
    return Row(loaded, make_result(statistics=statistics), 1.0)


@pytest.fixture(scope="module")
def cells():
    return make_cells({name: made_up_row(name) for name in ROWS})


def find(cells, table, row, column):
    (cell,) = [cell for cell in cells if (cell.table, cell.row, cell.column) == (table, row, column)]
    return cell


def test_every_printed_number_has_its_cell(cells):
    printed = sum(len(columns) for rows in PRINTED["table1"].values() for columns in rows.values())
    assert len([cell for cell in cells if cell.table == 1]) == printed + len(ROWS)
    assert len([cell for cell in cells if cell.table == 2]) == 4 * len(ROWS)
    assert len({(cell.table, cell.row, cell.column) for cell in cells}) == len(cells)


def test_printed_and_ours_are_not_mixed_up(cells):
    triangles = find(cells, 1, "knights", "shadow_volume_triangles")
    assert (triangles.printed, triangles.ours, triangles.kind) == (18000, 1000, "calibrated")
    depth = find(cells, 1, "powerplant", "depth_shadow H")
    assert (depth.printed, depth.kind) == (115.1, "predicted")
    assert depth.ours == (1000 + 1 + 2 * 7 + 1) / 2**20
    pixels = find(cells, 1, "amphitheater", "processed BF")
    assert (pixels.printed, pixels.ours, pixels.kind) == (5.03, 1007 / 1e6, "calibrated")
    ratio = find(cells, 1, "simple", "pixel_ratio BF:H")
    assert (ratio.printed, ratio.ours) == (12.7, 1007 / 1021)


def test_the_brute_force_column_and_two_rows_of_depth_bounds_are_calibrated(cells):
    for cell in cells:
        if cell.kind == "calibrated" and cell.column != "shadow_volume_triangles":
            chosen = cell.row in ("knights", "amphitheater") and cell.column.endswith(("DB", "BF:DB"))
            assert cell.column.endswith(" BF") or chosen


def test_nothing_of_the_hierarchical_column_is_calibrated(cells):
    assert not [cell for cell in cells if cell.column.endswith((" H", ":H")) and cell.kind == "calibrated"]
    assert {cell.kind for cell in cells if cell.column.endswith("BF:H")} == {"predicted"}


def test_nothing_printed_is_read_by_a_simulation():
    package = Path(aila2004.__file__).parents[1]
    readers = [path for path in package.rglob("*.py") if "printed.yaml" in path.read_text()]
    assert {path.relative_to(package).parts[0] for path in readers} == {"reproduce"}


@pytest.mark.parametrize("name", ROWS)
def test_rows_are_full_size(name):
    config = load_walkthrough(resources.experiment("aila2004") / f"{name}.yaml")
    assert config.name == name
    assert list(config.scene.resolution) == PRINTED["resolution"]
    own = config.shadow_volumes
    assert (own.psv_cache.size, own.delay_stream, own.tile) == (2048, 1 << 20, 8)
    assert own.counting == ("adaptive" if name == "amphitheater" else "z_fail")


@pytest.mark.slow
def test_the_paper_at_full_size():
    """Masks are equal in every frame, and the hierarchical algorithm saves what the paper says, roughly."""
    reproduction = aila2004.reproduce()
    assert all(row.result.ok for row in reproduction.rows.values())
    assert find(reproduction.cells, 1, "powerplant", "pixel_ratio BF:H").ours > 10
