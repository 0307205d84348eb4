"""How a light looks at a part of the view: along one axis if that fits a cone, else through the faces of a cube."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from archsim.shadowmap.faces import faces
from archsim.shadowmap.fit import NO_REGION
from archsim.shadowmap.view import View, corners, holds

WIDEST_CONE_DEGREES = 60.0  # from its axis; a face of a cube reaches 54.7
NEAREST = (
    0.02  # of the way from a point light to what is farthest of a piece: depths are clamped nearer to it
)
_AT_LIGHT = 1e-12  # of the way to the farthest corner: what is nearer has no direction from the light
_THINNEST = 1e-9  # side of a piece a unit before the light: a thinner one is left to those beside it
_SLACK = 1e-9


class Piece(NamedTuple):
    """What a light sees of a part of the view through one plane."""

    name: str  # of the cube's face; empty if there is only one piece
    axis: np.ndarray  # float64 [3] from the light
    outline: np.ndarray  # float64 [n, 3] points before the light, whose light rays enclose all its others
    region: np.ndarray  # float64 [m, 4] half-spaces of the light rays that belong to it
    from_light: bool  # it begins at a point light


def pieces(view: View, light: np.ndarray, near: float, far: float) -> list[Piece]:
    """The part of a view between two depths as a light sees it: one piece, or as many as a cube around it has."""
    part, bounds = view._replace(near=near, far=far), corners(view, near, far)
    from_light = bool(light[3]) and holds(part, light[:3])
    least = _AT_LIGHT * float(_lengths(bounds, light).max())
    outline = bounds[_lengths(bounds, light) > least]
    axis = cone_axis(light[3] * outline - light[:3])
    if axis is not None:
        return [Piece("", axis, outline, NO_REGION, from_light)]

    sides, found = [face.corners for face in faces(part)], []
    for number, name in enumerate(("right", "left", "up", "down", "ahead", "back")):
        turned = np.roll(view.axes, -(number // 2), axis=0)
        axis, across = turned[0] * (1 - 2 * (number % 2)), turned[1:]
        normals = np.array([axis + sign * side for side in across for sign in (1, -1)])
        outline = light[:3] + np.concatenate([clip(side - light[:3], normals) for side in sides])
        outline = outline[_lengths(outline, light) > least]
        if not _is_thin(outline - light[:3], axis, across):
            region = np.concatenate([normals, -(normals @ light[:3])[:, None]], axis=1)
            found.append(Piece(name, axis, outline, region, from_light))
    return found


def volume(piece: Piece, light: np.ndarray) -> np.ndarray:
    """Points [n, 3] whose hull holds a piece but for what is nearer than NEAREST to a point light."""
    if not light[3]:
        return piece.outline
    depths = (piece.outline - light[:3]) @ piece.axis
    least = NEAREST * depths.max()
    if depths.min() >= least and not piece.from_light:
        return piece.outline
    nearest = light[:3] + (piece.outline - light[:3]) * (least / depths)[:, None]
    return np.concatenate([nearest, piece.outline[depths >= least]])


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


def clip(polygon: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Corners [m, 3] of what of a convex polygon [n, 3] has normals [k, 3] . p >= 0; none if that is nothing."""
    for normal in normals:
        heights, kept = polygon @ normal, []
        for index, (here, height) in enumerate(zip(polygon, heights, strict=True)):
            before, was = polygon[index - 1], heights[index - 1]
            if min(was, height) < 0 < max(was, height):
                kept.append((was * here - height * before) / (was - height))
            if height >= 0:
                kept.append(here)
        polygon = np.array(kept).reshape(-1, 3)
    return polygon


def _lengths(points: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Of the light rays to points [n, 3]; all 1 if the light is infinitely far away."""
    return np.asarray(np.linalg.norm(light[3] * points - light[:3], axis=1))


def _is_thin(rays: np.ndarray, axis: np.ndarray, across: np.ndarray) -> bool:
    """Whether light rays [n, 3] hold next to nothing between them."""
    if len(rays) == 0:
        return True
    places = rays @ across.T / (rays @ axis)[:, None]
    return bool(np.ptp(places, axis=0).min() < _THINNEST)
