"""Fits one shadow map: a projection onto a plane along the light, a perspective within the plane, and a
depth.

A point p is moved along its light ray to q on the plane; there it has coordinates u (across) and t (along the
map's axis). The warp is a perspective in t with its centre at t_centre: the nearer the centre to the map, the
stronger.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class ShadowMap(NamedTuple):
    """One map and the part of space it serves."""

    name: str
    matrix: (
        np.ndarray
    )  # float64 [4, 4] world point to (x, y, z, w); x/w, y/w, z/w in [0, 1], y before the logarithm
    ratio: float  # of the logarithm along y; 1: none
    region: np.ndarray  # float64 [n, 4] half-spaces: the map serves points p with region . (p, 1) >= 0
    light: np.ndarray  # float64 [4]


class Plane(NamedTuple):
    """A plane to project to, with coordinates."""

    equation: np.ndarray  # float64 [4], unit normal; > 0 on the light's side
    origin: np.ndarray  # float64 [3] where u = t = 0
    across: np.ndarray  # float64 [3] unit vector of u
    along: np.ndarray  # float64 [3] unit vector of t


NO_REGION = np.zeros((0, 4))
_LEAST_HEIGHT = 1e-6  # of the light above the plane, against its distance


def make_plane(origin: np.ndarray, normal: np.ndarray, along: np.ndarray, light: np.ndarray) -> Plane | None:
    """A plane through `origin` turned to the light, t along `along` as nearly as can be; None if seen
    edge-on.
    """
    normal = normal / np.linalg.norm(normal)
    equation = np.array([*normal, -normal @ origin])
    towards = light[:3] - light[3] * origin
    height = equation @ light
    if abs(height) <= _LEAST_HEIGHT * np.linalg.norm(towards):
        return None
    equation = equation * np.sign(height)
    flat = along - (along @ normal) * normal
    flat = flat / np.linalg.norm(flat)
    return Plane(equation, origin, np.cross(flat, equation[:3]), flat)


def plane_across(axis: np.ndarray, points: np.ndarray, along: np.ndarray, light: np.ndarray) -> Plane:
    """The plane across an axis from the light, through the middle of points that all lie before the light."""
    if np.linalg.norm(np.cross(axis, along)) < 1e-9 * np.linalg.norm(axis) * np.linalg.norm(along):
        along = np.eye(3)[np.argmin(np.abs(axis))]  # the light shines along it: any direction will do
    plane = make_plane(points.mean(axis=0), axis, along, light)
    assert plane is not None
    return plane


def with_one(points: np.ndarray) -> np.ndarray:
    """Points [n, 3] as homogeneous ones [n, 4]."""
    return np.concatenate([points, np.ones((len(points), 1))], axis=1)


def plane_rows(plane: Plane, light: np.ndarray) -> np.ndarray:
    """Rows [3, 4]: a world point's u, t and weight after moving along the light to the plane."""
    onto = (plane.equation @ light) * np.eye(4) - np.outer(light, plane.equation)
    u = np.array([*plane.across, -plane.across @ plane.origin])
    t = np.array([*plane.along, -plane.along @ plane.origin])
    return np.stack([u, t, [0, 0, 0, 1.0]]) @ onto


def on_plane(plane: Plane, light: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(u, t) [n, 2] of world points."""
    moved = with_one(points) @ plane_rows(plane, light).T
    return np.asarray(moved[:, :2] / moved[:, 2:])


class Warp(NamedTuple):
    """How a map's plane is warped, and along which half-spaces its region ends."""

    centre: float | None  # t of the perspective's centre, before the map; None: not warped
    logarithmic: bool


def fit(
    name: str,
    plane: Plane,
    light: np.ndarray,
    outline: np.ndarray,
    volume: np.ndarray,
    warp: Warp,
    region: np.ndarray,
) -> ShadowMap:
    """The tightest map over `outline` whose depths reach over `volume`; both are points [n, 3] of the world.

    Nearer to the light than the volume, depths are clamped to 0.
    """
    rows = plane_rows(plane, light)
    u, t = on_plane(plane, light, outline).T
    first, last = t.min(), t.max()
    centre = warp.centre
    weight = rows[2] if centre is None else rows[1] - centre * rows[2]
    spread = u if centre is None else u / (t - centre)
    stretch = 1.0 if centre is None else last - centre
    x = (rows[0] - spread.min() * weight) / (spread.max() - spread.min())
    y = stretch * (rows[1] - first * rows[2]) / (last - first)

    heights = with_one(volume) @ plane.equation / (with_one(volume) @ weight)
    high, low = heights.max(), heights.min()
    z = (high * weight - plane.equation) / max(high - low, 1e-12)
    ratio = (last - centre) / (first - centre) if warp.logarithmic and centre is not None else 1.0
    return ShadowMap(name, np.stack([x, y, z, weight]), float(ratio), region, light)
