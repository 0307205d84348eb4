"""One light view, or all of a light's, by the plain algorithm from samples to shadow."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.raster.conservative import GridFragments, populated, rasterize
from archsim.raster.eye_view import EyeView
from archsim.scene.scene import Light, Scene
from archsim.shadow import izb
from archsim.shadow.grid import Grid
from archsim.shadow.light_view import LightFace, light_faces
from archsim.shadow.occluders import Occluders, set_up
from archsim.shadow.pixel_tiles import PixelTiles, cut, untile
from archsim.shadow.transform import LightTransform, light_transform
from archsim.shadow.workload import NOTHING, IzbWorkload, combined, extent


class Method(NamedTuple):
    """Choices of the algorithm."""

    grid: Grid
    pixel_tile: tuple[int, int]  # width, height in pixels
    offset_cells: float  # of the occluders' depth planes


class FacePlan(NamedTuple):
    """What is known of a light view before any sample is placed."""

    face: LightFace
    tiles: PixelTiles
    transform: LightTransform
    occluders: Occluders


def plan_faces(scene: Scene, eye_view: EyeView, light: Light, method: Method) -> list[FacePlan]:
    """The views that the light needs, ready for either the plain algorithm or the kernels."""
    return [
        FacePlan(
            face,
            cut(eye_view.reciprocal_depth, face.taken, method.pixel_tile),
            light_transform(scene, face, method.pixel_tile),
            set_up(scene, face, method.offset_cells),
        )
        for face in light_faces(scene, eye_view, light, method.grid)
    ]


def grid_fragments(plan: FacePlan, stencil: np.ndarray, grid: Grid) -> GridFragments:
    """Conservative rasterization with a margin above the rounding error of float32 edge functions."""
    margin = max(grid.logical_width, grid.logical_height) * 2.0**-20
    return rasterize(plan.occluders.setup, stencil, (grid.tile_width, grid.tile_height), margin)


class Outcome(NamedTuple):
    """What the plain algorithm finds for one light view."""

    samples: izb.Samples
    lists: izb.GridOfLists
    grid_fragments: GridFragments
    fragments: izb.Fragments
    z_test: izb.ZTest
    workload: IzbWorkload


def run_face(plan: FacePlan, grid: Grid, order: np.ndarray | None = None) -> Outcome:
    """Build and rasterize one light view; `order` of samples for list insertion, by default tile order."""
    samples = izb.place_samples(plan.tiles, plan.transform)
    lists = izb.build(samples, grid, np.arange(len(samples.cell)) if order is None else order)
    cells = grid_fragments(plan, lists.stencil, grid)
    fragments = izb.rasterize(samples, lists, grid, plan.occluders, cells)
    tested = izb.z_test_fragments(izb.z_test(samples), fragments.sample, fragments.depth)
    workload = IzbWorkload(
        int((samples.cell[:, 0] >= 0).sum()),
        int((lists.head >= 0).sum()),
        *extent(populated(lists.stencil)),
        cells.num_before_stencil,
        len(cells.i),
        izb.node_visits(lists, grid, cells),
        len(fragments.sample),
        tested.num_passed,
    )
    return Outcome(samples, lists, cells, fragments, tested, workload)


def shadow_mask(
    scene: Scene, eye_view: EyeView, light: Light, method: Method
) -> tuple[np.ndarray, IzbWorkload]:
    """bool [height, width], True in shadow, and the workload over all light views."""
    mask = np.zeros((scene.height, scene.width), np.bool_)
    workload = NOTHING
    for plan in plan_faces(scene, eye_view, light, method):
        outcome = run_face(plan, method.grid)
        shadow = izb.in_shadow(outcome.z_test, outcome.samples)
        mask |= untile(plan.tiles, shadow, scene.height, scene.width)
        workload = combined(workload, outcome.workload)
    return mask, workload
