"""Triangle setup in a light view: edge functions and the plane of depth, in logical cells. [Olano97]

For homogeneous vertices v = (X, Y, W), the edge function of v_i, v_j at (x, y) is (v_i x v_j) . (x, y, 1), and with
N = v0 x v1 + v1 x v2 + v2 x v0 and det = v0 . (v1 x v2) the reciprocal light depth is N . (x, y, 1) / det.
Depth, 1 - nearest / light depth, is linear too.
A cross product changes only its sign when its vertices change places, in floating point too: a sample on an edge that
two triangles share is never missed by both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.raster.conservative import Setup
from archsim.scene.scene import Scene
from archsim.shadow.light_view import LightFace


class Occluders(NamedTuple):
    """Triangles of a light view as the fragment processors see them."""

    setup: Setup
    edges: np.ndarray  # float32 [n, 3, 4] (a, b, 0, c)
    depth: np.ndarray  # float32 [n, 4] (a, b, 0, c): depth, with its offset


def set_up(scene: Scene, face: LightFace, offset_cells: float) -> Occluders:
    """Edge functions and depth planes of all triangles that the light sees at all, in submission order.

    The depth plane is moved by `offset_cells` (at least the rounding error) along its slope and by the rounding error
    of a depth, away from the light, so that no triangle shadows the samples that lie on it; where eye and light are on
    opposite sides of the triangle, towards the light, so that it does.
    """
    corners = scene.mesh.vertices.astype(np.float64)[scene.mesh.triangles]
    homogeneous = _transformed(corners - face.light, face.to_logical)
    v0, v1, v2 = homogeneous[:, 0], homogeneous[:, 1], homogeneous[:, 2]
    crosses = np.stack([np.cross(v1, v2), np.cross(v2, v0), np.cross(v0, v1)], axis=1)
    det = np.einsum("nk,nk->n", v0, crosses[:, 0])
    kept = np.flatnonzero((det != 0) & np.isfinite(det) & (homogeneous[:, :, 2] > 0).any(axis=1))

    edges = _normalised(crosses[kept] * np.sign(det[kept])[:, None, None])
    plane = np.array([0.0, 0.0, 1.0]) - face.nearest * crosses[kept].sum(axis=1) / det[kept, None]
    away = np.where(_opposed(corners[kept], np.asarray(scene.camera.eye), face.light), -1.0, 1.0)
    slope = np.abs(plane[:, :2]).sum(axis=1)
    plane[:, 2] += away * (slope * max(offset_cells, face.rounding_cells) + face.rounding_depth)
    setup = Setup(kept.astype(np.int32), edges, _bounds(homogeneous[kept]))
    return Occluders(setup, _as_attributes(edges), _as_attributes(plane))


def _transformed(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """matrix @ point for points [..., 3], written out so that equal points stay equal wherever they stand."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in matrix], axis=-1)


def _normalised(edges: np.ndarray) -> np.ndarray:
    """Edge functions scaled to max(|a|, |b|) = 1, by numbers that depend on the edge alone."""
    size = np.abs(edges[..., :2]).max(axis=-1)
    size = np.where(size > 0, size, np.maximum(np.abs(edges[..., 2]), np.finfo(np.float64).tiny))
    return edges / size[..., None]


def _opposed(corners: np.ndarray, eye: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Whether eye and light are strictly on opposite sides of each triangle's plane."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    eye_side = np.einsum("nk,nk->n", normal, eye - corners[:, 0])
    light_side = np.einsum("nk,nk->n", normal, light - corners[:, 0])
    return eye_side * light_side < 0


def _bounds(homogeneous: np.ndarray) -> np.ndarray:
    """Projected bounds [n, 4]; infinite for triangles that come near or behind the light plane."""
    depth = homogeneous[..., 2]
    crossing = depth.min(axis=1) <= 1e-9 * np.abs(depth).max(axis=1)
    position = homogeneous[..., :2] / np.where(crossing[:, None], 1.0, depth)[..., None]
    bounds = np.concatenate([position.min(axis=1), position.max(axis=1)], axis=1)
    bounds[crossing] = (-np.inf, -np.inf, np.inf, np.inf)
    return bounds


def _as_attributes(coefficients: np.ndarray) -> np.ndarray:
    """(a, b, c) as the float32 attribute (a, b, 0, c) that DPH takes."""
    attributes = np.zeros(coefficients.shape[:-1] + (4,), np.float32)
    attributes[..., [0, 1, 3]] = np.clip(coefficients, -3e38, 3e38)
    return attributes
