"""How far a shadow map aliases: m, the size of a texel in the image, in pixels. [Lloyd07] sec. 3, figure 7

On a surface: the larger of the lengths, in pixels, of a texel's two sides projected along the light to the
surface and then to the image. In space, where there is no surface: a texel's sides across the light against a
pixel across the line of sight.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.lograster.parameterization import constants, log_warp
from archsim.shadowmap.fit import ShadowMap, with_one
from archsim.shadowmap.view import View, pixel_size

AT_LIGHT = -1  # in place of the index of a map
_SAME_PLACE = 1e-7  # of the coordinates: what is nearer has no direction that is worth anything


class Places(NamedTuple):
    """Where world points are in a map, and how that changes with them."""

    x: np.ndarray  # float64 [n] in [0, 1] inside the map
    y: np.ndarray  # float64 [n] after the logarithm
    x_gradient: np.ndarray  # float64 [n, 3] change of x with the point
    y_gradient: np.ndarray  # float64 [n, 3]


def places(shadow_map: ShadowMap, points: np.ndarray) -> Places:
    """Where points [n, 3] are in a map."""
    image = with_one(points) @ shadow_map.matrix.T
    weight = image[:, 3:]
    x, y = image[:, 0] / image[:, 3], image[:, 1] / image[:, 3]
    rows = shadow_map.matrix[:, :3]
    x_gradient = (rows[0] - x[:, None] * rows[3]) / weight
    y_gradient = (rows[1] - y[:, None] * rows[3]) / weight
    if shadow_map.ratio == 1.0:
        return Places(x, y, x_gradient, y_gradient)
    c0, c1 = constants(shadow_map.ratio)
    inner = np.maximum(c1 * y + 1, 1e-12)
    slope = c0 * c1 / inner
    return Places(
        x,
        log_warp(np.minimum(y, (1e-12 - 1) / c1), shadow_map.ratio),
        x_gradient,
        slope[:, None] * y_gradient,
    )


def serves(shadow_map: ShadowMap, points: np.ndarray) -> np.ndarray:
    """Which points lie in a map's region; bool [n]."""
    sides = with_one(points) @ shadow_map.region.T
    scale = np.abs(points).max(initial=1.0)
    return np.asarray((sides >= -1e-9 * scale).all(axis=1))


def owner(maps: list[ShadowMap], points: np.ndarray) -> np.ndarray:
    """The map that serves each point: the first whose region it is in, else the one it is nearest to; int64
    [n]. AT_LIGHT where a point light is: no map has a place for that.
    """
    shortfalls = []
    for shadow_map in maps:
        sides = with_one(points) @ shadow_map.region.T
        shortfalls.append(np.minimum(sides, 0.0).min(axis=1, initial=0.0))
    light = maps[0].light
    distances = np.linalg.norm(light[3] * points - light[:3], axis=1)
    there = distances < _SAME_PLACE * light[3] * np.abs(points).max(initial=1.0)
    return np.where(there, AT_LIGHT, np.argmax(np.stack(shortfalls), axis=0))


def texel_sides(here: Places, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World vectors [n, 3] along the sides of a map that is one texel, on planes with the given normals [n,
    3].
    """
    return _side(here.x_gradient, here.y_gradient, normals), _side(here.y_gradient, here.x_gradient, normals)


def _side(gradient: np.ndarray, other: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """The vector in the plane along which one coordinate grows by 1 and the other stays."""
    along = np.cross(other, normals)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(along / (gradient * along).sum(axis=1, keepdims=True))


def in_image(view: View, points: np.ndarray, vectors: np.ndarray, rows: int) -> np.ndarray:
    """Lengths in pixels [n] of small world vectors at points, in an image of `rows` rows."""
    inside, steps = (points - view.eye) @ view.axes.T, vectors @ view.axes.T
    depth = inside[:, 2:]
    moved = (steps[:, :2] - inside[:, :2] / depth * steps[:, 2:]) / depth
    return np.asarray(np.linalg.norm(moved, axis=1) * rows / (2 * view.tan_y))


def surface_error(
    shadow_map: ShadowMap,
    size: tuple[int, int],
    view: View,
    points: np.ndarray,
    normals: np.ndarray,
    rows: int,
) -> np.ndarray:
    """m at surface points [n, 3] with normals [n, 3], for a map of size (columns, rows) texels."""
    across, along = texel_sides(places(shadow_map, points), normals)
    return np.maximum(
        in_image(view, points, across, rows) / size[0], in_image(view, points, along, rows) / size[1]
    )


def space_error(
    shadow_map: ShadowMap, view: View, points: np.ndarray, rows: int
) -> tuple[np.ndarray, np.ndarray]:
    """(across, along): sides of a map of one texel, across the light, in pixels at points [n, 3] in space."""
    rays = shadow_map.light[:3] - shadow_map.light[3] * points
    rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    across, along = texel_sides(places(shadow_map, points), rays)
    pixel = pixel_size(view, points, rows)
    return np.linalg.norm(across, axis=1) / pixel, np.linalg.norm(along, axis=1) / pixel
