"""Workloads: sizes that fit each other and the scene."""

from __future__ import annotations

import pytest

from archsim.config import load_run

RUN = "runs/tiny.yaml"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("light=1", "workload.light: must be below 1, not 1: the scene has one light"),
        ("light=-1", "workload.light: must be at least 0, not -1"),
        ("light=0.0", "workload.light: must be a whole number, not 0.0"),
        (
            "logical_grid=[66, 64]",
            "workload.logical_grid.0: the width must be a multiple of the grid_tile's 4, not 66",
        ),
        ("logical_grid=[64, 4100]", "workload.logical_grid.1: must be at most 4096, not 4100"),
        (
            "logical_grid=[4096, 4096]",
            "workload.logical_grid: must have fewer than 16777216 cells: the kernels number them in a float; "
            "it has 16777216",
        ),
        ("logical_grid=[0, 64]", "workload.logical_grid.0: must be at least 1, not 0"),
        (
            "physical_grid=[32, 2]",
            "workload.physical_grid.1: the height must be a multiple of the grid_tile's 4, not 2",
        ),
        ("physical_grid=[32, 96]", "workload.physical_grid.1: the height must be a power of two, not 96"),
        ("physical_grid=[-32, 32]", "workload.physical_grid.0: must be at least 1, not -32"),
        ("physical_grid=32", "workload.physical_grid: must be a list, not 32"),
        ("pixel_tile=[7, 8]", "workload.pixel_tile.0: the width must be even (pixels go in pairs), not 7"),
        ("pixel_tile=[32, 16]", "workload.pixel_tile: a tile has at most 122 pairs of pixels, not 256"),
        ("depth_offset_cells=-0.5", "workload.depth_offset_cells: must be at least 0, not -0.5"),
    ],
)
def test_sizes_that_do_not_fit_are_said(problems, override, message):
    override = f"workload.{override}"
    assert problems(load_run, RUN, [override]) == [f"--set {override}: {message}"]


def test_both_axes_are_told_together(problems):
    override = "workload.grid_tile=[3, 5]"
    found = problems(load_run, RUN, [override])
    assert f"--set {override}: workload.grid_tile.0: the width must be a power of two, not 3" in found
    assert f"--set {override}: workload.grid_tile.1: the height must be a power of two, not 5" in found
    assert len(found) == 6  # the grids are no multiples of it either


@pytest.mark.parametrize(
    "override", ["pixel_tile=[2, 122]", "pixel_tile=[2, 1]", "logical_grid=[4, 4096]", "depth_offset_cells=0"]
)
def test_limits_are_inside(override):
    assert load_run(RUN, [f"workload.{override}"])


def test_defaults():
    workload = load_run("runs/izb_bloodprison_light1.yaml").workload
    assert (workload.light, workload.tile_order, workload.depth_offset_cells) == (1, "interleaved", 1 / 64)


DRAWN = "runs/izb_drawn.yaml"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("list_length=1.2", "workload.list_length: must be at least 5, not 1.2: there are 262144 lists"),
        (
            "stencil=[1025, 600]",
            "workload.stencil.0: the width must be at most the logical grid's 1024, not 1025",
        ),
        ("patch=[60, 64]", "workload.patch.0: the width must be a multiple of the pixel_tile's 8, not 60"),
        (
            "grid_fragments_post_stencil=1600001",
            "workload.grid_fragments_post_stencil: must be at most grid_fragments_pre_stencil, 1600000",
        ),
        ("light=0", "unknown key 'workload.light'"),
        ("list_lenght=6", "unknown key 'workload.list_lenght'; did you mean 'list_length'?"),
    ],
)
def test_statistics_that_contradict_each_other_are_said(problems, override, message):
    override = f"workload.{override}"
    assert problems(load_run, DRAWN, [override]) == [f"--set {override}: {message}"]


def test_a_scene_is_there_if_and_only_if_the_workload_is_of_one(problems, write):
    with_scene = write("with.yaml", "base: runs/izb_drawn.yaml\nscene: scenes/tiny.yaml\n")
    assert problems(load_run, with_scene) == [
        "with.yaml:2:1: scene: must be left out: the workload 'izb_drawn' is not of a scene"
    ]
    without = write(
        "without.yaml", "name: x\nworkload: workloads/izb_tiny.yaml\nmachine: machines/tiny.yaml\n"
    )
    assert problems(load_run, without) == [
        "without.yaml:1:1: scene: is missing: the workload 'izb' needs one"
    ]
