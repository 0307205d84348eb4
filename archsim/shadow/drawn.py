"""An irregular shadow map without a scene: samples and triangles drawn so that the workload has given statistics.

What [Johnson04] table 1 prints of a light view is all that goes in. What it leaves open is drawn in the plainest way:

    surfaces    the eye view is cut into patches, turned at random; the light sees each as a rectangle at its own
                place, of one density: the cosine towards the eye over that towards the light
    triangles   right-angled, their legs exponential, each either anywhere on the light view or where a sample is
    depths      uniform; all samples have one depth

One number each is then sought for: the size of the rectangles for the length of the lists, the length of the legs and
the share of triangles placed on samples for the grid fragments, how many triangles for the framebuffer fragments, the
samples' depth for those that pass the z test. The kernels then run on it as on any light view.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.raster.eye_view import EyeView
from archsim.shadow import izb
from archsim.shadow.drawn_samples import DrawnSamples, draw_samples
from archsim.shadow.drawn_triangles import Built, Wanted, draw_triangles
from archsim.shadow.grid import Grid
from archsim.shadow.light_view import LightFace
from archsim.shadow.plain import FacePlan, grid_fragments, run_face
from archsim.shadow.workload import IzbWorkload

_DRAWINGS = 8  # of surfaces of one size, at most
_SIZES = (1, 2, 4)  # of patches, as multiples of the one asked for
_DEPTH_STEPS = 20  # bisections of the samples' depth
_FAR = 0.05  # relative error of a statistic beyond which the drawn light view is not what was asked for


class Statistics(NamedTuple):
    """What is asked for. Sizes are (width, height)."""

    resolution: tuple[int, int]  # pixels, each with a sample
    list_length: float  # samples, over the lists that have any
    stencil: tuple[int, int]  # extent of the populated logical cells
    grid_fragments: tuple[int, int]  # before and after the stencil
    framebuffer_fragments: tuple[int, int]  # before and after the z test
    patch: tuple[int, int]  # pixels of a surface; more if triangles fit larger ones only
    neighbours: bool  # whether triangles that follow each other are near each other


def draw(statistics: Statistics, grid: Grid, tile: tuple[int, int], seed: int) -> tuple[FacePlan, EyeView]:
    """A light view with about these statistics, and the eye view it belongs to. The same seed, the same view.

    Surfaces on which no triangles fit the fragments are drawn again, and if that does not help, larger.
    """
    rng = np.random.default_rng([seed, 0])
    for size in np.repeat(_SIZES, _DRAWINGS).tolist():
        patch = (size * statistics.patch[0], size * statistics.patch[1])
        drawn = draw_samples(statistics._replace(patch=patch), grid, tile, rng)
        plan, built = _with_triangles(statistics, grid, drawn, seed)
        far = _far(statistics, run_face(plan, grid).workload)
        if not far:
            break
    else:
        what, wanted, nearest = far[0]
        hint = "try smaller or larger patches"
        raise fail(f"cannot draw a workload of {wanted:g} {what}: the nearest has {nearest:g}", hint=hint)

    depth = _sample_depth(plan, grid, built, statistics.framebuffer_fragments[1])
    transform = drawn.transform._replace(depth=np.array([0, 0, depth, 1], np.float32))
    seen = EyeView(drawn.image, drawn.patch_of_pixel, np.ones(drawn.image.shape, np.int32))
    return plan._replace(transform=transform), seen


def _with_triangles(
    statistics: Statistics, grid: Grid, drawn: DrawnSamples, seed: int
) -> tuple[FacePlan, Built]:
    """The drawn samples, in lists, and triangles for them."""
    samples = izb.place_samples(drawn.tiles, drawn.transform)
    lists = izb.build(samples, grid, np.arange(len(samples.cell)))
    wanted = Wanted(*statistics.grid_fragments, statistics.framebuffer_fragments[0])
    occluders = draw_triangles(wanted, grid, (samples, lists), statistics.neighbours, seed)
    taken = np.ones(drawn.image.shape, np.bool_)
    face = LightFace(np.eye(3), np.zeros(3), taken, nearest=1.0, rounding_cells=0.0, rounding_depth=0.0)
    return FacePlan(face, drawn.tiles, drawn.transform, occluders), (samples, lists)


def _sample_depth(plan: FacePlan, grid: Grid, built: Built, wanted: int) -> float:
    """The depth of all samples at which about so many fragments pass the z test: more pass, the deeper they lie."""
    samples, lists = built
    cells = grid_fragments(plan, lists.stencil, grid)
    fragments = izb.rasterize(samples, lists, grid, plan.occluders, cells)
    low, high = 0.0, 1.0
    for _ in range(_DEPTH_STEPS):
        middle = 0.5 * (low + high)
        surface = izb.ZTest(np.full(len(samples.cell), middle, np.float32), 0)
        passed = izb.z_test_fragments(surface, fragments.sample, fragments.depth).num_passed
        low, high = (middle, high) if passed < wanted else (low, middle)
    return 0.5 * (low + high)


def _far(statistics: Statistics, found: IzbWorkload) -> list[tuple[str, float, float]]:
    """(what, wanted, found) of the statistics that came out too far from what was asked for."""
    triples = [
        ("lists' length", statistics.list_length, found.list_length),
        ("grid fragments before the stencil", statistics.grid_fragments[0], found.grid_fragments_pre_stencil),
        ("grid fragments after the stencil", statistics.grid_fragments[1], found.grid_fragments_post_stencil),
        ("framebuffer fragments", statistics.framebuffer_fragments[0], found.framebuffer_fragments_pre_z),
    ]
    return [(what, wanted, near) for what, wanted, near in triples if abs(near - wanted) > _FAR * wanted + 1]
