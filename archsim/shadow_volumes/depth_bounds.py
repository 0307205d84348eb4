"""Depth bounds of each shadow volume, as [Aila04] sec. 6 computes them.

The bounds of an object are those of its bounding box, extended by the part of the box' shadow volume that the view's
frustum holds. What a pixel outside of them shows can't be in the object's shadow.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import njit
from archsim.scene.scene import Scene
from archsim.shadow_volumes.casters import Casters
from archsim.shadow_volumes.polygon import Frustum, new_polygon, project
from archsim.shadow_volumes.volumes import box_corners, clear_of_near_plane, extruded, seen_by

_NARROW = 0.01  # cosine; a box that the light sees at a wider angle than that has no bounds
_WIDER = 1 + 2.0**-18  # of the bounds: for rounding, and for NEARER in tiles.py

# Corner i of a box has bit 0, 1, 2 of i as its x, y, z side; seen from outside, faces are counterclockwise.
_FACES = np.array([(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)])
_TRIANGLES = np.concatenate([_FACES[:, [0, 1, 2]], _FACES[:, [0, 2, 3]]])


def depth_bounds(scene: Scene, light: np.ndarray, box: np.ndarray, reach: float | None) -> np.ndarray:
    """float64 [n, 2]: least and greatest closeness, 1 / z, that the object in each box [n, 2, 3] can shadow."""
    camera, width, height = scene.camera, scene.width, scene.height
    bounds = np.empty((len(box), 2))
    bounds[:] = np.inf, 0.0
    depth = seen_by(_homogeneous(box_corners(box)), camera, width, height)[:, 2].reshape(-1, 8)
    seen = depth.max(axis=1, initial=0.0) > camera.near
    bounds[seen, 0] = 1.0 / depth[seen].max(axis=1)
    bounds[seen, 1] = 1.0 / np.maximum(depth[seen].min(axis=1), 1e-300)

    casters = Casters(*_box_mesh(box), len(box))
    narrowness = _narrowness(box, light)
    end = None if reach is None else np.repeat(_end_of_box_volumes(box, light, reach, narrowness), 8)
    points, triangles, starts, _ = extruded(casters, light, np.zeros(len(box), bool), end)
    frustum = Frustum(camera.near, -1.5, width + 0.5, -1.5, height + 0.5)
    _extend(seen_by(points, camera, width, height), triangles, starts, frustum, new_polygon(), bounds)
    bounds[~clear_of_near_plane(box, scene, light), 1] = np.inf

    around = ((box[:, 0] <= light) & (light <= box[:, 1])).all(axis=1)
    if reach is not None:
        around |= narrowness < _NARROW
    bounds[around] = 0.0, np.inf
    return bounds * np.array([1 / _WIDER, _WIDER])


def _end_of_box_volumes(
    box: np.ndarray, light: np.ndarray, reach: float, narrowness: np.ndarray
) -> np.ndarray:
    """How far from the light the box' volume has to end [n] to hold all volumes of what is in it that end at `reach`.

    Its dark cap is flat: between the corners' rays it is nearer to the light than on them.
    """
    farthest = np.linalg.norm(box_corners(box) - light, axis=2).max(axis=1)
    return np.maximum(reach, farthest) / np.maximum(narrowness, _NARROW)


def _narrowness(box: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Cosine [n] of the greatest angle between the rays from the light to the box' centre and to a corner."""
    to_corners, to_centre = box_corners(box) - light, box.mean(axis=1) - light
    lengths = np.linalg.norm(to_corners, axis=2) * np.linalg.norm(to_centre, axis=1)[:, None]
    return (np.einsum("nci,ni->nc", to_corners, to_centre) / np.maximum(lengths, 1e-300)).min(axis=1)


def _box_mesh(box: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """positions, triangles, caster and part of Casters: each box by itself."""
    first = 8 * np.arange(len(box))
    triangles = (first[:, None, None] + _TRIANGLES).reshape(-1, 3)
    number = np.repeat(np.arange(len(box)), len(_TRIANGLES))
    return box_corners(box).reshape(-1, 3), triangles, number, number


def _homogeneous(points: np.ndarray) -> np.ndarray:
    flat = points.reshape(-1, 3)
    return np.concatenate([flat, np.ones((len(flat), 1))], axis=1)


@njit
def _extend(points, triangles, starts, frustum, polygon, bounds):
    """Extend the bounds of each volume by the corners of its triangles, cut to the frustum."""
    for volume in range(len(bounds)):
        for index in range(starts[volume], starts[volume + 1]):
            for corner in range(project(points, triangles[index], frustum, polygon)):
                bounds[volume, 0] = min(bounds[volume, 0], polygon.corners[corner, 2])
                bounds[volume, 1] = max(bounds[volume, 1], polygon.corners[corner, 2])
