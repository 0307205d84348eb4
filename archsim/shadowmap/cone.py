"""How a light looks at a part of the view: along one axis if that fits a cone, else through the faces of a cube."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from archsim.shadowmap.fit import with_one
from archsim.shadowmap.view import View, corners

WIDEST_CONE_DEGREES = 60.0  # from its axis; a face of a cube reaches 54.7
NEAREST = 0.02  # of the way from a light inside a part to what is farthest: depths are clamped nearer to it
_SLACK = 1e-9


class Piece(NamedTuple):
    """What a light sees of a part of the view through one plane."""

    name: str  # of the cube's face; empty if there is only one piece
    axis: np.ndarray  # float64 [3] from the light
    points: np.ndarray  # float64 [n, 3] whose hull it is
    region: np.ndarray  # float64 [m, 4] half-spaces of the light rays that belong to it


def pieces(view: View, light: np.ndarray, near: float, far: float) -> list[Piece]:
    """The part of a view between two depths as a light sees it: one piece, or as many as a cube around it has."""
    part = corners(view, near, far)
    axis = cone_axis(light[:3] - light[3] * part)
    if axis is not None:
        return [Piece("", -axis, part, np.zeros((0, 4)))]
    found = []
    for number, face in enumerate(("right", "left", "up", "down", "ahead", "back")):
        sign, axis = 1 - 2 * (number % 2), view.axes[number // 2]
        sides = [view.axes[(number // 2 + turn) % 3] for turn in (1, 2)]
        region = _pyramid(light[:3], sign * axis, sides)
        reach = float(np.max((part - light[:3]) @ (sign * axis)))
        if reach <= 0:
            continue
        cut = np.array([*(sign * axis), -sign * axis @ light[:3] - NEAREST * reach])
        points = hull(np.concatenate([_planes(view, near, far), region, cut[None]]))
        if len(points):
            found.append(Piece(face, sign * axis, points, region))
    return found


def cone_axis(directions: np.ndarray) -> np.ndarray | None:
    """The axis of the narrowest cone around directions [n, 3], unit length; None if it is too wide."""
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    axes = [a + b for a, b in itertools.combinations_with_replacement(unit, 2)]
    for a, b, c in itertools.combinations(unit, 3):
        normal = np.cross(b - a, c - a)
        axes += [normal, -normal]
    lengths = np.linalg.norm(axes, axis=1)
    candidates = np.array(axes)[lengths > _SLACK] / lengths[lengths > _SLACK, None]
    cosines = (candidates @ unit.T).min(axis=1)
    best = int(cosines.argmax())
    return candidates[best] if cosines[best] >= math.cos(math.radians(WIDEST_CONE_DEGREES)) else None


def hull(planes: np.ndarray) -> np.ndarray:
    """Corners [n, 3] of the points with planes [m, 4] . (p, 1) >= 0; none if they enclose nothing."""
    planes = planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    triples = np.array(list(itertools.combinations(range(len(planes)), 3)))
    normals, constants = planes[triples, :3], planes[triples, 3]
    proper = np.abs(np.linalg.det(normals)) > _SLACK
    points = np.linalg.solve(normals[proper], -constants[proper][..., None])[..., 0]
    scale = np.abs(points).max(initial=1.0)
    return np.asarray(points[(with_one(points) @ planes.T >= -_SLACK * scale).all(axis=1)])


def _pyramid(apex: np.ndarray, axis: np.ndarray, sides: list[np.ndarray]) -> np.ndarray:
    """Half-spaces of a cube's face as seen from its middle."""
    normals = np.array([axis + sign * side for side in sides for sign in (1, -1)])
    return np.concatenate([normals, -(normals @ apex)[:, None]], axis=1)


def _planes(view: View, near: float, far: float) -> np.ndarray:
    """Half-spaces of the part of a view between two depths."""
    right, up, forward = view.axes
    normals = [view.tan_x * forward + sign * right for sign in (1, -1)]
    normals += [view.tan_y * forward + sign * up for sign in (1, -1)]
    sides = [[*normal, -normal @ view.eye] for normal in normals]
    depth = np.array([*forward, -forward @ view.eye])
    return np.array([*sides, depth - [0, 0, 0, near], [0, 0, 0, far] - depth])
