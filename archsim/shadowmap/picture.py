"""What the viewer sees of a mesh, and how large the texels of shadow maps are there, pixel by pixel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.raster.eye_view import eye_view
from archsim.scene.camera import Camera, pixel_rays
from archsim.scene.mesh import Mesh
from archsim.shadowmap.error import owner, places, surface_error
from archsim.shadowmap.fit import ShadowMap
from archsim.shadowmap.view import View, depth_of


class Picture(NamedTuple):
    """The visible surfaces between the view's near and far depth."""

    seen: np.ndarray  # bool [rows, columns]
    points: np.ndarray  # float64 [n, 3] world points of the pixels seen, row after row
    normals: np.ndarray  # float64 [n, 3] of the surfaces there, unit length


class Aliasing(NamedTuple):
    """The errors of a set of maps in a picture."""

    error: np.ndarray  # float64 [n] m of each pixel seen; 0 at a point light
    owner: np.ndarray  # int64 [n] its map, or AT_LIGHT
    texel: np.ndarray  # float64 [n, 2] its place in that map, in texels


def take_picture(mesh: Mesh, camera: Camera, view: View, columns: int, rows: int) -> Picture:
    """What the camera sees of a mesh at pixel centres."""
    seen = eye_view(mesh, camera, columns, rows)
    there = seen.triangle >= 0
    row, column = np.nonzero(there)
    rays = pixel_rays(camera, columns, rows)
    depth = 1.0 / seen.reciprocal_depth[there].astype(np.float64)
    directions = rays.corner + column[:, None] * rays.step_x + row[:, None] * rays.step_y
    points = rays.origin + depth[:, None] * directions

    corners = mesh.vertices[mesh.triangles[seen.triangle[there]]].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    near_enough = (depth_of(view, points) <= view.far) & (lengths > 0)
    there[row[~near_enough], column[~near_enough]] = False
    return Picture(there, points[near_enough], normals[near_enough] / lengths[near_enough, None])


def aliasing(
    maps: list[ShadowMap], sizes: Sequence[tuple[int, int]], view: View, picture: Picture
) -> Aliasing:
    """m of every pixel seen, in maps of the given (columns, rows)."""
    owners = owner(maps, picture.points)
    error = np.zeros(len(picture.points))
    texel = np.zeros((len(picture.points), 2))
    for index, (shadow_map, size) in enumerate(zip(maps, sizes, strict=True)):
        mine = owners == index
        points, normals = picture.points[mine], picture.normals[mine]
        error[mine] = surface_error(shadow_map, size, view, points, normals, picture.seen.shape[0])
        here = places(shadow_map, points)
        texel[mine] = np.stack([here.x * size[0], here.y * size[1]], axis=1)
    return Aliasing(error, owners, texel)
