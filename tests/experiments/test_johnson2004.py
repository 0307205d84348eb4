"""The calibration tool: its estimate from few pixels, its start from a scene, the same options giving the same view."""

import importlib
import sys

import numpy as np
import pytest

from archsim import resources
from archsim.config import load_scene as load_config
from archsim.raster.eye_view import eye_view
from archsim.scene.scene import load_scene
from archsim.shadow.grid import Grid
from archsim.shadow.plain import Method, plan_faces, run_face
from archsim.trace.records import RECORD, Op, Tasks

FOLDER = resources.experiment("johnson2004")


@pytest.fixture(scope="module")
def experiment():
    """Load one of the experiment's scripts by name."""
    sys.path.insert(0, str(FOLDER))
    try:
        yield importlib.import_module
    finally:
        sys.path.remove(str(FOLDER))


@pytest.fixture(scope="module")
def calibrate(experiment):
    return experiment("calibrate")


def test_a_scene_is_found_again_among_the_guesses(calibrate):
    scene = load_scene(load_config(FOLDER / "doom_start.yaml"))
    camera = calibrate.doom_theme().stage(calibrate.guess_of(scene)).camera
    np.testing.assert_allclose(camera.eye, scene.camera.eye, atol=1e-3)
    forward = (scene.camera.target - scene.camera.eye) / np.linalg.norm(
        scene.camera.target - scene.camera.eye
    )
    np.testing.assert_allclose((camera.target - camera.eye) / calibrate.REACH[0], forward, atol=1e-3)
    assert camera.fovy_degrees == pytest.approx(scene.camera.fovy_degrees, abs=1e-3)


def test_few_pixels_tell_what_many_would(calibrate):
    """Columns from a sixteenth of the pixels are within a tenth of those at a resolution twice as fine."""
    from light_fit import measure

    scene = load_scene(load_config("scenes/knot_and_spheres.yaml", ["resolution=[160, 128]"]))
    finer = scene._replace(width=320, height=256)
    coarse, fine = (
        measure(each, eye_view(each.mesh, each.camera, each.width, each.height), scene.lights[0], scale)
        for each, scale in ((scene, 8), (finer, 4))
    )
    np.testing.assert_allclose(coarse.columns, fine.columns, rtol=0.1)


def test_estimates_at_full_size_are_the_workload(calibrate):
    """At scale 1 nothing is estimated: the columns are those of the plain algorithm."""
    from light_fit import LOGICAL, PHYSICAL, TILE, measure

    scene = load_scene(load_config("scenes/knot_and_spheres.yaml", ["resolution=[64, 48]"]))
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    method = Method(Grid(LOGICAL, LOGICAL, PHYSICAL, PHYSICAL, TILE, TILE), (8, 8), 1 / 64)
    (plan,) = plan_faces(scene, seen, scene.lights[0], method)
    workload = run_face(plan, method.grid).workload

    columns = measure(scene, seen, scene.lights[0], 1).columns

    assert columns[0] == workload.list_length
    assert tuple(columns[1:3]) == (workload.stencil_width, workload.stencil_height)
    assert columns[3] == pytest.approx(workload.grid_fragments_pre_stencil / 1e6, rel=1e-3)
    assert columns[5] == workload.framebuffer_fragments_pre_z / 1e6


def test_the_same_options_give_the_same_guesses(calibrate):
    theme = calibrate.knot_theme()
    first, again = (calibrate.random_guess(theme, np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(first.numbers, again.numbers)
    assert first.choices == again.choices
    assert len(theme.stage(first).mesh.triangles) == 16_372


@pytest.fixture(scope="module")
def sensitivity(experiment):
    return experiment("sensitivity")


@pytest.fixture(scope="module")
def nodes(experiment):
    return experiment("nodes")


@pytest.fixture(scope="module")
def orders(experiment):
    return experiment("orders")


def test_lists_in_another_order_keep_their_heads_and_tasks(sensitivity):
    """Two tasks: a head and three nodes, of which the second is a hit; a head and one node."""
    ops = [Op.LOAD, Op.LOAD, Op.LOAD, Op.EMIT, Op.LOAD, Op.END, Op.LOAD, Op.LOAD, Op.END]
    records = np.zeros(len(ops), RECORD)
    records["op"], records["address"] = ops, [4, 160, 320, 7, 480, 0, 8, 640, 0]
    tasks = Tasks(np.array([0, 6, 9]), records)

    (oldest_first,) = sensitivity.reordered([tasks], sensitivity.LIST_ORDERS["lists oldest first"])
    (shuffled,) = sensitivity.reordered([tasks], sensitivity.LIST_ORDERS["lists in random order"])

    assert oldest_first.records["address"].tolist() == [4, 480, 320, 7, 160, 0, 8, 640, 0]
    assert sorted(shuffled.records["address"][[1, 2, 4]].tolist()) == [160, 320, 480]
    assert shuffled.records["address"][[0, 6, 7]].tolist() == [4, 8, 640]
    assert records["address"].tolist() == [4, 160, 320, 7, 480, 0, 8, 640, 0]


def test_every_choice_of_the_sensitivity_table_can_be_configured(sensitivity):
    for row in sensitivity.ROWS:
        for overrides in (*sensitivity.MACHINES.values(), *sensitivity.PICTURES.values()):
            if (
                row.startswith("drawn_")
                or not overrides
                or not overrides[0].startswith(sensitivity.ONLY_DRAWN)
            ):
                assert sensitivity.load_row(row, overrides)


def test_the_paper_visits_the_nodes_that_its_useful_cycles_take(nodes):
    """Doom light 1: 4 x 9,663,102 x 94.32 % instructions, less 5 a fragment and 2 a hit, over 7 a node."""
    issued = 4 * 9_663_102 * 0.9432
    expected = (issued - 5 * 110_000 - 2 * 3_050_000) / 7 / 3_050_000
    assert nodes.nodes_of_the_paper("drawn_doom_light1") == pytest.approx(expected)
    assert expected == pytest.approx(1.396, abs=0.001)


def test_a_line_through_drawings(nodes):
    drawings = [nodes.Visited(n, 1 + 2 * n, 98.0) for n in (1.0, 1.25, 1.5)]
    slope, start, error = nodes.line(drawings)
    assert (slope, start, error) == pytest.approx((2, 1, 0))


def test_every_variant_of_a_drawing_can_be_configured(nodes):
    for row in ("drawn_doom_light0", "drawn_doom_light1", "drawn_knot_light0"):
        for _, overrides in nodes.variants(row):
            assert nodes.load_row(row, overrides)
    counts = [overrides[0].rpartition("=")[2] for _, overrides in nodes.variants("drawn_doom_light1")]
    assert counts[:2] == ["105000", "115000"]


def test_orders_keep_the_fragments(orders, sensitivity):
    config = sensitivity.load_row("knot_light0", ["scene.resolution=[64, 48]"])
    (view,) = orders.prepare(config.workload, orders.takes(config), orders.subject_of(config))
    list(view.build().chunks)
    found = orders.fragments_of(view)
    for name, order in orders.orders(view, found):
        np.testing.assert_array_equal(np.sort(order), np.arange(len(found.i)), err_msg=name)
        triangle = found.setup_index[order]
        if name.startswith("cells of a triangle"):
            np.testing.assert_array_equal(triangle, found.setup_index, err_msg=name)


def test_a_z_order_curve_goes_right_before_it_goes_down(orders):
    bounds = np.array([[x, y, x, y] for x, y in [(17, 17), (1, 17), (17, 1), (1, 1), (33, 1)]], float)
    assert orders.z_order(bounds, 16).tolist() == [3, 2, 1, 0, 4]


def test_a_stencil_of_physical_cells_lets_pass_what_shares_a_list(orders):
    """Logical 4 x 2 cells on physical 2 x 2, tiles of 1 x 1: (i, j) lies at ((i + j // 2) % 2, (j + i // 2) % 2)."""
    grid = orders.Grid(4, 2, 2, 2, 1, 1)
    logical = np.zeros((2, 4), np.bool_)
    logical[0, 0] = logical[0, 3] = logical[1, 0] = True  # physical (0, 0), (1, 1), (0, 1)
    heads = np.array([7, -1, 8, 9], np.int32)
    marked = orders.physical_stencil(logical, heads, grid)
    assert marked.tolist() == [[True, False, True, True], [True, True, True, False]]


def test_pixels_beside_an_edge(experiment):
    shadow = np.zeros((4, 5), np.bool_)
    shadow[1, 1] = True
    found = experiment("irregular_error").edges(shadow)
    assert found[:3, :3].all()
    assert found.sum() == 9
