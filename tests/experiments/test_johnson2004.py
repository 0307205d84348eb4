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
def calibrate():
    sys.path.insert(0, str(FOLDER))
    try:
        yield importlib.import_module("calibrate")
    finally:
        sys.path.remove(str(FOLDER))


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
def sensitivity():
    sys.path.insert(0, str(FOLDER))
    try:
        yield importlib.import_module("sensitivity")
    finally:
        sys.path.remove(str(FOLDER))


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
