"""Tables 1 to 4 of Johnson et al. 2004 made of small results; the full size is the slow test."""

import ast
from pathlib import Path

import pytest
import yaml

from archsim import resources
from archsim.config import load_run_with_origins
from archsim.reproduce import johnson2004
from archsim.reproduce.cells import KINDS
from archsim.reproduce.johnson2004 import ROWS, RUNS, Row, make_cells
from archsim.run.result import Statistic
from tests.run.results import make_result

PRINTED = yaml.safe_load((resources.experiment("johnson2004") / "printed.yaml").read_text())


def made_up_row(name: str) -> Row:
    """A row whose statistics are 1000, 1001, 1002 ... in the order of `names`."""
    workload = "depth_complexity list_length stencil_width stencil_height grid_fragments_pre_stencil "
    workload += "grid_fragments_post_stencil framebuffer_fragments_pre_z framebuffer_fragments_post_z"
    names = [f"workload.{what}" for what in workload.split()]
    for phase, ratio in (("izb_build", "cycles_per_point"), ("izb_raster", "cycles_per_tri_sample")):
        names += [f"{phase}.{what}" for what in ("cycles", "frames_per_second", ratio, "useful_percent")]
    names += [f"izb_build.{cache}.average_miss_cycles" for cache in ("cpu_l1", "l2")]
    names += [f"izb_raster.{cache}.average_miss_cycles" for cache in ("fragment_l1", "l2")]
    names += [statistic for _, statistic, _ in johnson2004._EXTRA]
    statistics = [Statistic(each, 1000 + k, "", "") for k, each in enumerate(names)]
    loaded = load_run_with_origins(resources.experiment("johnson2004") / f"{name}.yaml")
    return Row(loaded, make_result(statistics=statistics), 1.0)


@pytest.fixture(scope="module")
def cells():
    return make_cells({name: made_up_row(name) for name in RUNS})


def find(cells, table, row, column):
    (cell,) = [cell for cell in cells if (cell.table, cell.row, cell.column) == (table, row, column)]
    return cell


def test_every_printed_number_has_its_cell(cells):
    assert [len([cell for cell in cells if cell.table == table]) for table in (1, 2, 3, 4)] == [
        72,
        34,
        24,
        24,
    ]
    assert len({(cell.table, cell.row, cell.column) for cell in cells}) == len(cells)
    assert {cell.kind for cell in cells} == set(KINDS)


def test_printed_and_ours_are_not_mixed_up(cells):
    cycles = find(cells, 3, "doom_light1", "cycles")
    assert (cycles.printed, cycles.ours, cycles.kind) == (25805020, 1008, "predicted")

    fragments = find(cells, 1, "knot_light0", "framebuffer_fragments_pre_z")
    assert (fragments.printed, fragments.ours, fragments.unit) == (3.52, 1006 / 1e6, "million")

    average = find(cells, 2, "L2", "miss_average raster doom_light0")
    assert (average.printed, average.ours) == ([75, 118], 1019)


def test_traffic_left_out_follows_from_table_1(cells):
    """Doom light 0: 1.60 MB of stencil, 4 x 4.36 MB read and 4 x 1.22 MB written in 19,401,660 cycles."""
    total = find(cells, 5, "doom_light0", "all_of_it")
    assert total.printed == pytest.approx(23.92e6 / 19401660, abs=1e-4)
    assert find(cells, 5, "drawn_doom_light0", "z_read").printed == pytest.approx(17.44)


def test_what_is_not_printed_has_no_error(cells):
    waited = find(cells, 6, "knot_light0", "locks_waited_for")
    assert (waited.printed, waited.error_percent, waited.unit) == (None, None, "grants")


def test_sizes_are_exact_and_minima_are_measured(cells):
    exact = [cell for cell in cells if cell.kind == "exact"]
    assert len(exact) == 24 + 8
    assert all(cell.error_percent == 0 for cell in exact)
    assert [find(cells, 2, level, "miss_minimum").ours for level in ("L1", "L2")] == [6, 42]


def test_sizes_come_from_the_machine_and_not_from_the_paper():
    rows = {name: made_up_row(name) for name in RUNS}
    changed = load_run_with_origins(
        resources.experiment("johnson2004") / "doom_light0.yaml", ["machine.components.l2.size=512 KiB"]
    )
    rows["doom_light0"] = rows["doom_light0"]._replace(loaded=changed)

    size = find(make_cells(rows), 2, "L2", "size")

    assert (size.printed, size.ours, size.error_percent) == (256, 512, 100)


def test_nothing_printed_is_read_anywhere_else():
    package = Path(johnson2004.__file__).parents[1]
    readers = [path for path in package.rglob("*.py") if "printed.yaml" in path.read_text()]
    assert {path.relative_to(package).parts[0] for path in readers} == {"reproduce"}

    tree = ast.parse(Path(johnson2004.__file__).read_text())
    simulating = next(node for node in tree.body if getattr(node, "name", "") == "simulate_row")
    assert "printed" not in ast.unparse(simulating)


def test_both_phases_have_the_caches_of_the_one_row_that_table_2_prints():
    machine = made_up_row("doom_light0").config.machine.components
    fields = ("size", "ways", "line", "hit_cycles")
    assert [getattr(machine["cpu_l1"], f) for f in fields] == [
        getattr(machine["fragment_l1"], f) for f in fields
    ]


@pytest.mark.parametrize("name", ROWS)
def test_rows_are_full_size(name):
    config = made_up_row(name).config
    assert config.name == name
    assert list(config.scene.resolution) == PRINTED["resolution"]


@pytest.mark.parametrize("name", ROWS)
def test_drawn_rows_ask_for_table_1_and_nothing_else(name):
    workload, row = made_up_row(f"drawn_{name}").config.workload, PRINTED["table1_workload"][name]
    grid, frame = row["grid_fragments_M"], row["framebuffer_fragments_M"]
    assert list(workload.resolution) == PRINTED["resolution"]
    assert (workload.list_length, list(workload.stencil)) == (row["list_length"], row["stencil"])
    assert workload.grid_fragments_pre_stencil == pytest.approx(1e6 * grid["pre"])
    assert workload.grid_fragments_post_stencil == pytest.approx(1e6 * grid["post"])
    assert workload.framebuffer_fragments_pre_z == pytest.approx(1e6 * frame["pre_z"])
    assert workload.framebuffer_fragments_post_z == pytest.approx(1e6 * frame["post_z"])


@pytest.mark.slow
def test_the_paper_at_full_size():
    """Every law holds, and what the machine alone decides comes out near the paper."""
    reproduction = johnson2004.reproduce()

    assert all(row.result.ok for row in reproduction.rows.values())
    for name in ROWS:
        per_point = find(reproduction.cells, 3, name, "cycles_per_point")
        assert abs(per_point.error_percent) < 5
