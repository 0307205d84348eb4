"""The image reference: visibility and shadows by ray tracing in float64, sharing nothing with the rasterizer.

Rays meet triangles by Moeller and Trumbore's test ([Moller97]), found in the tree of `box_tree.py`.

A pixel is in shadow iff it shows geometry, at point P of triangle T, and
  (a) a triangle other than T meets the open segment from P to the light, or
  (b) eye and light lie on strictly opposite sides of T's plane.
Hits within `clearance` of P, as a part of the segment, do not count: the neighbours of T share its edges,
and in a mesh of rounded coordinates stand out of its plane by some 1e-7 of the coordinates.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.raster.eye_view import EyeView
from archsim.scene.camera import pixel_rays
from archsim.scene.scene import Scene
from archsim.shadow.box_tree import FAR, INNER, STACK, box_entry, build_tree, push_nearer_last

_CLEARANCE = (
    1e-5  # part of the way from P to the light, or of P's distances from eye and origin if those are less
)
_EDGE_SLACK = 1e-12  # barycentric; a ray along a shared edge must not slip through
_SAME_DEPTH = 1e-12  # relative; rounding does not choose between coplanar triangles


class PrimaryHits(NamedTuple):
    """What the rays through the pixel centres meet first; row 0 is the top."""

    depth: np.ndarray  # float64 [height, width] z along the forward axis, inf where nothing is met
    triangle: np.ndarray  # int32 [height, width] -1 where nothing is met; of equally near ones the lower


def primary_hits(scene: Scene) -> PrimaryHits:
    """Trace one ray through each pixel centre; hits before the near plane do not count."""
    rays = pixel_rays(scene.camera, scene.width, scene.height)
    depth = np.full((scene.height, scene.width), np.inf)
    triangle = np.full((scene.height, scene.width), -1, dtype=np.int32)
    _trace_primary(build_tree(scene.mesh), rays, float(scene.camera.near), depth, triangle)
    return PrimaryHits(depth, triangle)


def shadow_mask(scene: Scene, light_index: int, eye_view: EyeView | None = None) -> np.ndarray:
    """Bool [height, width], True where a pixel is in shadow of that light; False where there is no geometry.

    Triangle T is that of `eye_view`, or traced when it is None; P is where the pixel's ray meets T's plane.
    """
    visible = primary_hits(scene).triangle if eye_view is None else eye_view.triangle
    rays = pixel_rays(scene.camera, scene.width, scene.height)
    light = np.asarray(scene.lights[light_index].position, dtype=np.float64)
    shadow = np.zeros((scene.height, scene.width), dtype=np.bool_)
    _trace_shadows(build_tree(scene.mesh), rays, light, visible, shadow)
    return shadow


@njit
def _trace_primary(tree, rays, near, depth, triangle):
    """Nearest hit of every pixel's ray, into `depth` and `triangle` [height, width]."""
    origin = (rays.origin[0], rays.origin[1], rays.origin[2])
    stack = np.empty(STACK, dtype=np.int64)
    height, width = triangle.shape
    for y in range(height):
        for x in range(width):
            depth[y, x], triangle[y, x] = _nearest(tree, origin, _direction(rays, x, y), near, stack)


@njit
def _trace_shadows(tree, rays, light, visible, shadow):
    """The rule at the top of this file for every pixel, into `shadow` [height, width]."""
    origin = (rays.origin[0], rays.origin[1], rays.origin[2])
    stack = np.empty(STACK, dtype=np.int64)
    height, width = shadow.shape
    for y in range(height):
        for x in range(width):
            own = visible[y, x]
            if own < 0:
                continue
            corners = tree.corners[own]
            point = _where_plane(corners, origin, _direction(rays, x, y))
            if _height(corners, origin) * _height(corners, light) < 0:
                shadow[y, x] = True
            else:
                least = clearance(point, origin, light)
                shadow[y, x] = _is_blocked(tree, point, _minus(light, point), least, own, stack)


@njit
def clearance(point, eye, light):
    """Ray parameter up to which a hit on the way to the light may be rounding; it does not grow with a far light."""
    way, reach = np.sqrt(_square(_minus(light, point))), np.sqrt(_square(_minus(point, eye)))
    return _CLEARANCE * min(way, reach + np.sqrt(_square(point))) / max(way, 1e-300)


@njit
def _square(p):
    return _dot(p, p)


@njit
def _nearest(tree, origin, direction, near, stack):
    """Depth and index of the first triangle at or beyond `near` along the ray; (inf, -1) if it meets none."""
    inverse = _inverse(direction)
    depth, triangle = np.inf, -1
    waiting = 1
    stack[0] = 0
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        if box_entry(tree, node, origin, inverse) > min(depth * (1 + _SAME_DEPTH), FAR):
            continue
        first = tree.first[node]
        for place in range(first, first + tree.number[node]):
            index = tree.order[place]
            hit = _hit(tree.corners[index], origin, direction)
            if hit >= near and _is_before(hit, index, depth, triangle):
                depth, triangle = hit, index
        if tree.number[node] == INNER:
            waiting = push_nearer_last(tree, first, (origin, inverse), stack, waiting)
    return depth, triangle


@njit
def _is_before(hit, index, depth, triangle):
    """Whether triangle `index` at `hit` is seen rather than `triangle` at `depth`; of coplanar ones the lower."""
    same = abs(hit - depth) < _SAME_DEPTH * depth
    return index < triangle if same else hit < depth


@njit
def _is_blocked(tree, origin, direction, least, own, stack):
    """Whether a triangle other than `own` meets the ray at a parameter between `least` and 1."""
    inverse = _inverse(direction)
    waiting = 1
    stack[0] = 0
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        if box_entry(tree, node, origin, inverse) > 1:
            continue
        first = tree.first[node]
        for place in range(first, first + tree.number[node]):
            index = tree.order[place]
            if index != own and least < _hit(tree.corners[index], origin, direction) < 1:
                return True
        if tree.number[node] == INNER:
            stack[waiting], stack[waiting + 1] = first, first + 1
            waiting += 2
    return False


@njit
def _hit(corners, origin, direction):
    """Ray parameter at which the ray meets the triangle, from either side; inf if it does not."""
    edge1 = _minus(corners[1], corners[0])
    edge2 = _minus(corners[2], corners[0])
    p = _cross(direction, edge2)
    determinant = _dot(edge1, p)
    if determinant == 0:
        return np.inf
    offset = _minus(origin, corners[0])
    q = _cross(offset, edge1)
    u = _dot(offset, p) / determinant
    v = _dot(direction, q) / determinant
    if u < -_EDGE_SLACK or v < -_EDGE_SLACK or u + v > 1 + _EDGE_SLACK:
        return np.inf
    return _dot(edge2, q) / determinant


@njit
def _where_plane(corners, origin, direction):
    """The point in which the ray meets the triangle's plane."""
    normal = _normal(corners)
    depth = _dot(normal, _minus(corners[0], origin)) / _dot(normal, direction)
    return (
        origin[0] + depth * direction[0],
        origin[1] + depth * direction[1],
        origin[2] + depth * direction[2],
    )


@njit
def _height(corners, point):
    """Of the point above the triangle's plane, in units of twice the triangle's area."""
    return _dot(_normal(corners), _minus(point, corners[0]))


@njit
def _normal(corners):
    return _cross(_minus(corners[1], corners[0]), _minus(corners[2], corners[0]))


@njit
def _direction(rays, x, y):
    """Of the ray through the centre of pixel (x, y), 1 along the forward axis."""
    return (
        rays.corner[0] + x * rays.step_x[0] + y * rays.step_y[0],
        rays.corner[1] + x * rays.step_x[1] + y * rays.step_y[1],
        rays.corner[2] + x * rays.step_x[2] + y * rays.step_y[2],
    )


@njit
def _inverse(direction):
    """Reciprocals; 1e300 for 0, which keeps 0 x inf = NaN out of the box test."""
    return (_reciprocal(direction[0]), _reciprocal(direction[1]), _reciprocal(direction[2]))


@njit
def _reciprocal(number):
    return 1 / number if abs(number) > 1e-300 else 1e300


@njit
def _minus(p, q):
    return (p[0] - q[0], p[1] - q[1], p[2] - q[2])


@njit
def _cross(p, q):
    return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])


@njit
def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
