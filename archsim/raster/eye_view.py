"""The z-prepass: what each pixel of the eye view sees, and how many triangles it looks through."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.raster.edges import edge_functions, pixel_box, reciprocal_depth
from archsim.scene.camera import Camera, to_view_space, view_window
from archsim.scene.mesh import Mesh

SAME_DEPTH = 1e-12  # relative


class EyeView(NamedTuple):
    """The visible geometry at pixel centres; row 0 is the top."""

    reciprocal_depth: np.ndarray  # float32 [height, width] 1 / z, NaN where there is no geometry
    triangle: np.ndarray  # int32 [height, width] index of the visible triangle, -1 where there is none
    covered: np.ndarray  # int32 [height, width] triangles at z >= near; its mean is the depth complexity


def eye_view(mesh: Mesh, camera: Camera, width: int, height: int) -> EyeView:
    """Rasterize the mesh by [Olano97]. The nearest triangle is seen; of equally near ones, the lower.

    Depths are equal within SAME_DEPTH, so that rounding does not choose between coplanar triangles. A triangle
    seen exactly edge-on covers nothing.
    """
    nearest = np.zeros((height, width), dtype=np.float64)
    triangle = np.full((height, width), -1, dtype=np.int32)
    covered = np.zeros((height, width), dtype=np.int32)
    corners = to_view_space(mesh.vertices, camera)[mesh.triangles]

    _draw(corners, view_window(camera, width, height), nearest, triangle, covered)
    with np.errstate(over="ignore"):
        depths = np.where(triangle >= 0, nearest, np.nan).astype(np.float32)
    return EyeView(depths, triangle, covered)


@njit
def _draw(corners, window, nearest, triangle, covered):
    """Draw triangles in order, view-space corners float64 [n, 3, 3]; `nearest` is the largest 1 / z."""
    for index in range(len(corners)):
        box = pixel_box(corners[index], window)
        if box.first_x >= box.end_x or box.first_y >= box.end_y:
            continue
        edges = edge_functions(corners[index], window)
        if edges.volume > 0:
            _draw_triangle(index, edges, (box, window.near), (nearest, triangle, covered))


@njit
def _draw_triangle(index, edges, bounds, image):
    """Draw one triangle where it is at z >= near; `bounds` is (PixelBox, near)."""
    box, near = bounds
    nearest, triangle, covered = image
    for y in range(box.first_y, box.end_y):
        for x in range(box.first_x, box.end_x):
            closeness = reciprocal_depth(edges, x, y)
            if closeness > 0 and closeness * near <= 1:
                covered[y, x] += 1
                if closeness > nearest[y, x] * (1 + SAME_DEPTH):
                    nearest[y, x] = closeness
                    triangle[y, x] = index
