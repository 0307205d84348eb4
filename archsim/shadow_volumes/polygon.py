"""A shadow-volume triangle on the screen: clipped in homogeneous coordinates, then divided.

Equal edges are clipped to equal edges whichever triangle they belong to, so that closed volumes stay closed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, inlined

GUARD = 32768.0  # pixels up to which polygons are kept beyond the screen
MOST_CORNERS = 8  # a triangle cut by five planes
_PLANES = 5
_ROUNDING = 2.0**-45  # of rounding, relative to closeness


class Frustum(NamedTuple):
    """What polygons are cut to; x and y in pixels."""

    near: float  # least depth
    left: float
    right: float
    top: float
    bottom: float


class Polygon(NamedTuple):
    """Space for one polygon; every array is overwritten by the next."""

    clipped: np.ndarray  # float64 [2, MOST_CORNERS + 1, 4] homogeneous
    corners: (
        np.ndarray
    )  # float64 [MOST_CORNERS + 1, 3] x, y in pixels and closeness; the first again after the last


class Plane(NamedTuple):
    """Closeness over the polygon: at (x, y) base + x_factor (x - x0) + y_factor (y - y0), within low ... high."""

    base: float
    x0: float
    y0: float
    x_factor: float
    y_factor: float
    low: float  # least at a corner
    high: float
    error: float  # of rounding, as far as it may matter


def new_polygon() -> Polygon:
    return Polygon(np.zeros((2, MOST_CORNERS + 1, 4)), np.zeros((MOST_CORNERS + 1, 3)))


@compiled
def project(points, triangle, frustum, polygon):
    """Clip a triangle of `seen_by` points and fill polygon.corners; the number of corners, 0 if nothing is left."""
    outside = 0
    everywhere = (1 << _PLANES) - 1
    for corner in range(3):
        point = points[triangle[corner]]
        code = 0
        for plane in range(_PLANES):
            if _height(point, plane, frustum) < 0:
                code |= 1 << plane
        outside |= code
        everywhere &= code
        for k in range(4):
            polygon.clipped[0, corner, k] = point[k]
    if everywhere:
        return 0

    number, source = 3, 0
    for plane in range(_PLANES):
        if outside >> plane & 1:
            number = _clip(polygon.clipped, source, number, plane, frustum)
            source = 1 - source
            if number < 3:
                return 0
    return _divide(polygon, source, number)


@inlined
def _height(point, plane, frustum):
    """Above a clipping plane; the kept side is >= 0."""
    if plane == 0:
        return point[2] - frustum.near * point[3]
    if plane == 1:
        return point[0] - frustum.left * point[2]
    if plane == 2:
        return frustum.right * point[2] - point[0]
    if plane == 3:
        return point[1] - frustum.top * point[2]
    return frustum.bottom * point[2] - point[1]


@compiled
def _clip(clipped, source, number, plane, frustum):
    """Cut the polygon in clipped[source] by a plane into the other one; its number of corners."""
    kept = 0
    target = 1 - source
    for corner in range(number):
        a, b = clipped[source, corner], clipped[source, corner + 1 if corner + 1 < number else 0]
        height_a, height_b = _height(a, plane, frustum), _height(b, plane, frustum)
        if height_a >= 0:
            for k in range(4):
                clipped[target, kept, k] = a[k]
            kept += 1
        if (height_a >= 0) != (height_b >= 0):
            _cut(a, b, height_a, height_b, clipped[target, kept])
            kept += 1
    return kept


@inlined
def _cut(a, b, height_a, height_b, out):
    """The point of the edge a b on the plane; the same for b a."""
    if height_a >= 0:
        share = height_a / (height_a - height_b)
        for k in range(4):
            out[k] = a[k] + share * (b[k] - a[k])
    else:
        share = height_b / (height_b - height_a)
        for k in range(4):
            out[k] = b[k] + share * (a[k] - b[k])


@compiled
def _divide(polygon, source, number):
    """Corners on the screen; their number, 0 if one has no place."""
    for corner in range(number):
        z = polygon.clipped[source, corner, 2]
        if not z > 0:
            return 0
        polygon.corners[corner, 0] = polygon.clipped[source, corner, 0] / z
        polygon.corners[corner, 1] = polygon.clipped[source, corner, 1] / z
        polygon.corners[corner, 2] = polygon.clipped[source, corner, 3] / z
    for k in range(3):
        polygon.corners[number, k] = polygon.corners[0, k]
    return number


@compiled
def plane_of(corners, number):
    """Plane through the polygon, from its widest triangle; without one flat, and uncertain."""
    low, high = corners[0, 2], corners[0, 2]
    best, widest = 1, 0.0
    reach = 0.0
    for corner in range(number):
        low, high = min(low, corners[corner, 2]), max(high, corners[corner, 2])
        reach = max(reach, abs(corners[corner, 0] - corners[0, 0]), abs(corners[corner, 1] - corners[0, 1]))
        if 1 <= corner < number - 1:
            area = abs(_area(corners, corner))
            if area > widest:
                best, widest = corner, area

    # Coordinates are uncertain by 2^-36 pixels (52 bits below GUARD, and clipping), areas by reach times that.
    uncertain = 2.0**-34 * reach / widest if widest > 0 else 1.0
    error = min(1.0, uncertain) * (high - low) + _ROUNDING * high
    if uncertain >= 1.0:
        return Plane(high, 0.0, 0.0, 0.0, 0.0, low, high, error)
    area = _area(corners, best)
    x1, y1 = corners[best, 0] - corners[0, 0], corners[best, 1] - corners[0, 1]
    x2, y2 = corners[best + 1, 0] - corners[0, 0], corners[best + 1, 1] - corners[0, 1]
    rise1, rise2 = corners[best, 2] - corners[0, 2], corners[best + 1, 2] - corners[0, 2]
    x_factor = (rise1 * y2 - rise2 * y1) / area
    y_factor = (rise2 * x1 - rise1 * x2) / area
    return Plane(corners[0, 2], corners[0, 0], corners[0, 1], x_factor, y_factor, low, high, error)


@inlined
def _area(corners, corner):
    """Twice the signed area of the triangle of corners 0, `corner` and the next."""
    x1, y1 = corners[corner, 0] - corners[0, 0], corners[corner, 1] - corners[0, 1]
    x2, y2 = corners[corner + 1, 0] - corners[0, 0], corners[corner + 1, 1] - corners[0, 1]
    return x1 * y2 - x2 * y1


@inlined
def closeness(plane, x, y):
    """Of the polygon at a pixel."""
    value = plane.base + plane.x_factor * (x - plane.x0) + plane.y_factor * (y - plane.y0)
    return min(max(value, plane.low), plane.high)


@inlined
def closeness_range(plane, x, y, half):
    """Bounds of `closeness`, rounding included, over the square of half width `half` around (x, y)."""
    value = plane.base + plane.x_factor * (x - plane.x0) + plane.y_factor * (y - plane.y0)
    spread = half * (abs(plane.x_factor) + abs(plane.y_factor))
    low = min(max(value - spread, plane.low), plane.high) - plane.error
    high = max(min(value + spread, plane.high), plane.low) + plane.error
    return low, high
