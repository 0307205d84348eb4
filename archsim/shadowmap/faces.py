"""Face partitioning: a shadow map for each face of the view frustum through which light leaves it. [Lloyd07]
sec. 3.1

Every point of the view is served by the face that its light ray leaves through. A side face is a trapezoid
whose long edges meet at the eye; a perspective from there makes it a square, in which the logarithm then
spaces depth evenly. A side face whose long edges open wide, as seen from the light, is split along its
middle, and each half has its perspective turned to its own middle.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from archsim.shadowmap.fit import Plane, ShadowMap, Warp, fit, make_plane, on_plane, with_one
from archsim.shadowmap.view import View, at_depth

WIDEST_DEGREES = (
    90.0  # between the long edges of a side face, as seen from the light; the paper prints no number
)
_ON_FACE = 33  # samples along each side of a face, to find how far its light rays reach
_NEAREST = 0.02  # of the way from a light inside the view to a face: depths are clamped nearer to it


class Face(NamedTuple):
    """A face of the frustum: corners in order around it, the first two on the near plane if it is a side."""

    name: str
    corners: np.ndarray  # float64 [4, 3]
    is_side: bool


def faces(view: View) -> list[Face]:
    """The six faces."""

    def corner(x: float, y: float, depth: float) -> np.ndarray:
        return at_depth(view, np.array(x), np.array(y), np.array(depth))

    found = []
    for name, one, other in (
        ("left", (-1, -1), (-1, 1)),
        ("right", (1, 1), (1, -1)),
        ("bottom", (1, -1), (-1, -1)),
        ("top", (-1, 1), (1, 1)),
    ):
        ends = [
            corner(*one, view.near),
            corner(*other, view.near),
            corner(*other, view.far),
            corner(*one, view.far),
        ]
        found.append(Face(name, np.array(ends), True))
    for name, depth in (("near", view.near), ("far", view.far)):
        square = [corner(x, y, depth) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        found.append(Face(name, np.array(square), False))
    return found


def face_maps(view: View, light: np.ndarray, logarithmic: bool) -> list[ShadowMap]:
    """A map, or two halves, for each face that light leaves through; the end faces are not warped."""
    middle = at_depth(view, np.array(0.0), np.array(0.0), np.array(0.5 * (view.near + view.far)))
    maps = []
    for face in faces(view):
        normal = np.cross(face.corners[1] - face.corners[0], face.corners[3] - face.corners[0])
        centre = face.corners.mean(axis=0)
        plane = make_plane(centre, normal, _axis(face, view), light)
        if plane is None or plane.equation @ [*middle, 1.0] <= 0:
            continue
        if logarithmic and face.is_side and _opening(face, light) > math.radians(WIDEST_DEGREES):
            maps += [_map(half, plane, view, light, True, True) for half in _halves(face)]
        else:
            maps.append(_map(face, plane, view, light, logarithmic, False))
    return maps


def _axis(face: Face, view: View) -> np.ndarray:
    """The direction of t: away from the eye on sides, up on ends."""
    if not face.is_side:
        return np.asarray(view.axes[1])
    return np.asarray(face.corners[2:].mean(axis=0) - face.corners[:2].mean(axis=0))


def _opening(face: Face, light: np.ndarray) -> float:
    """The angle between the long edges of a side face as seen from the light."""
    centre = face.corners.mean(axis=0)
    towards = light[:3] - light[3] * centre
    towards = towards / np.linalg.norm(towards)
    edges = [face.corners[3] - face.corners[0], face.corners[2] - face.corners[1]]
    flat = [edge - (edge @ towards) * towards for edge in edges]
    cosine = flat[0] @ flat[1] / (np.linalg.norm(flat[0]) * np.linalg.norm(flat[1]))
    return math.acos(min(1.0, max(-1.0, float(cosine))))


def _halves(face: Face) -> list[Face]:
    """Both halves of a side face, cut along its middle."""
    near, far = face.corners[:2].mean(axis=0), face.corners[2:].mean(axis=0)
    one = np.array([face.corners[0], near, far, face.corners[3]])
    other = np.array([near, face.corners[1], face.corners[2], far])
    return [Face(f"{face.name} 1", one, True), Face(f"{face.name} 2", other, True)]


def _map(
    face: Face, plane: Plane, view: View, light: np.ndarray, logarithmic: bool, turned: bool
) -> ShadowMap:
    """The map of a face or half a face."""
    face_plane = plane
    if turned:
        plane = _turned_plane(face, plane, view, light)
    centre = None
    if face.is_side:
        eye = float(on_plane(plane, light, view.eye[None])[0, 1])
        t = on_plane(plane, light, face.corners)[:, 1]
        first, last = t.min() - eye, t.max() - eye
        centre = eye if logarithmic else eye - math.sqrt(first * last)
    volume = _reached(face, face_plane, view, light)
    warp = Warp(centre, logarithmic and face.is_side)
    return fit(face.name, plane, light, face.corners, volume, warp, _region(face, light, volume.mean(axis=0)))


def _turned_plane(half: Face, plane: Plane, view: View, light: np.ndarray) -> Plane:
    """A plane across the light with its axis from the eye along the middle of a half; the face's own if that
    fails.
    """
    centre = half.corners.mean(axis=0)
    along = centre - view.eye
    across_light = make_plane(centre, light[:3] - light[3] * centre, along, light)
    assert across_light is not None
    points = np.concatenate([half.corners, view.eye[None]])
    if (
        light[3]
        and (with_one(points) @ across_light.equation >= 0.98 * (light @ across_light.equation)).any()
    ):
        return plane
    u, t = on_plane(across_light, light, points).T
    edges = [np.array([u[k] - u[4], t[k] - t[4]]) for k in (2, 3)]
    middle = sum(edge / np.linalg.norm(edge) for edge in edges)
    bisector = middle[0] * across_light.across + middle[1] * across_light.along
    turned = make_plane(centre, across_light.equation[:3], bisector, light)
    assert turned is not None
    t = on_plane(turned, light, points)[:, 1]
    return turned if t[:4].min() > t[4] else plane


def _region(face: Face, light: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Half-spaces of the points whose light ray meets the face: planes through the light and each of its
    edges.
    """
    planes = []
    for index in range(4):
        one, other = face.corners[index], face.corners[(index + 1) % 4]
        normal = np.cross(other - one, light[:3] - light[3] * one)
        normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
        planes.append(np.array([*normal, -normal @ one]))
    signs = np.sign(np.array(planes) @ [*inside, 1.0])
    return np.asarray(np.array(planes) * signs[:, None])


def _reached(face: Face, plane: Plane, view: View, light: np.ndarray) -> np.ndarray:
    """Points of the face, and where the light rays that leave through them entered the view; float64 [n, 3]."""
    a, b = np.meshgrid(np.linspace(0.01, 0.99, _ON_FACE), np.linspace(0.01, 0.99, _ON_FACE))
    a, b = a.ravel()[:, None], b.ravel()[:, None]
    c = face.corners
    leaving = (1 - b) * ((1 - a) * c[0] + a * c[1]) + b * ((1 - a) * c[3] + a * c[2])
    towards = light[:3] - light[3] * leaving  # the light is at 1 if it is a point, at infinity otherwise
    longest = np.full(len(leaving), 1 - _NEAREST if light[3] else np.inf)
    for other in faces(view):
        normal = np.cross(other.corners[1] - other.corners[0], other.corners[3] - other.corners[0])
        normal = normal / np.linalg.norm(normal)
        height, step = (leaving - other.corners[0]) @ normal, towards @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = -height / step
        scale = np.linalg.norm(other.corners[2] - other.corners[0])
        ahead = (reach > 1e-9) & (np.abs(height) > 1e-9 * scale)
        longest = np.where(ahead, np.minimum(longest, reach), longest)
    return np.concatenate([leaving, leaving + longest[:, None] * towards])
