"""Edge functions by two-dimensional homogeneous rasterization ([Olano97]: Olano and Greer 1997).

With view-space corners v0, v1, v2 and a pixel's direction d, edge i is d . (v_j x v_k): zero where the pixel
looks at the line v_j v_k, and together the weights of the corners in the point that the pixel sees. No corner
is ever divided by its depth, so a triangle that passes behind the eye needs no clipping.

Equal corners in the opposite order give exactly negated edge functions, so that no pixel falls between
triangles that share an edge; a pixel exactly on a shared edge belongs to both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from archsim.jit import njit


class EdgeFunctions(NamedTuple):
    """A triangle over pixel (x, y): edge i is x_factor[i] x + y_factor[i] y + constant[i], >= 0 inside."""

    x_factor: tuple[float, float, float]
    y_factor: tuple[float, float, float]
    constant: tuple[float, float, float]
    volume: float  # |v0 . (v1 x v2)|; volume / (sum of the edges) is the depth; 0 for a triangle seen edge-on


@njit
def edge_functions(corners, window):
    """EdgeFunctions of a triangle given by its view-space corners, float64 [3, 3], in a ViewWindow."""
    normal0 = _cross(corners[1], corners[2])
    normal1 = _cross(corners[2], corners[0])
    normal2 = _cross(corners[0], corners[1])
    volume = corners[0, 0] * normal0[0] + corners[0, 1] * normal0[1] + corners[0, 2] * normal0[2]
    turn = -1.0 if volume < 0 else 1.0

    edge0 = _over_pixels(normal0, turn, window)
    edge1 = _over_pixels(normal1, turn, window)
    edge2 = _over_pixels(normal2, turn, window)
    return EdgeFunctions(
        (edge0[0], edge1[0], edge2[0]),
        (edge0[1], edge1[1], edge2[1]),
        (edge0[2], edge1[2], edge2[2]),
        turn * volume,
    )


@njit
def edge_value(edges, index, x, y):
    """Edge `index` at the centre of pixel (x, y); every caller gets the same bits."""
    return edges.x_factor[index] * x + edges.y_factor[index] * y + edges.constant[index]


@njit
def reciprocal_depth(edges, x, y):
    """1 / z of the triangle at the centre of pixel (x, y), or 0.0 where it does not cover the pixel."""
    edge0 = edge_value(edges, 0, x, y)
    edge1 = edge_value(edges, 1, x, y)
    edge2 = edge_value(edges, 2, x, y)
    if edge0 >= 0 and edge1 >= 0 and edge2 >= 0:
        return (edge0 + edge1 + edge2) / edges.volume
    return 0.0


@njit
def _cross(p, q):
    return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])


@njit
def _over_pixels(normal, turn, window):
    """x factor, y factor and constant of `turn` x direction . normal."""
    constant = window.left * normal[0] + window.top * normal[1] + normal[2]
    return turn * (window.step_x * normal[0]), turn * (window.step_y * normal[1]), turn * constant


class PixelBox(NamedTuple):
    """Pixels first_x <= x < end_x, first_y <= y < end_y; empty if an end is not beyond its first."""

    first_x: int
    first_y: int
    end_x: int
    end_y: int


@njit
def pixel_box(corners, window):
    """PixelBox that holds every pixel centre where the triangle can be seen at z >= near."""
    low_x, low_y, high_x, high_y = math.inf, math.inf, -math.inf, -math.inf
    for i in range(3):
        a, b = corners[i], corners[(i + 1) % 3]
        if a[2] >= window.near:
            x, y = _projected(a[0], a[1], a[2], window)
            low_x, low_y, high_x, high_y = min(low_x, x), min(low_y, y), max(high_x, x), max(high_y, y)
        if (a[2] >= window.near) != (b[2] >= window.near):
            x, y = _where_near(a, b, window)
            low_x, low_y, high_x, high_y = min(low_x, x), min(low_y, y), max(high_x, x), max(high_y, y)
    return PixelBox(
        _clamped(np.floor(low_x), window.width),
        _clamped(np.floor(low_y), window.height),
        _clamped(np.ceil(high_x) + 1, window.width),
        _clamped(np.ceil(high_y) + 1, window.height),
    )


@njit
def _where_near(a, b, window):
    """Pixel coordinates of the point of the segment a b with z = near; the same for b a."""
    if a[2] < b[2]:
        a, b = b, a
    part = (a[2] - window.near) / (a[2] - b[2])
    return _projected(a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), window.near, window)


@njit
def _projected(x, y, z, window):
    """Pixel coordinates of a view-space point; whole numbers are pixel centres."""
    return (x / z - window.left) / window.step_x, (y / z - window.top) / window.step_y


@njit
def _clamped(coordinate, size):
    return int(min(max(coordinate, 0.0), float(size)))
