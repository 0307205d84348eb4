"""Conventional shadow maps: depths at texel centres, compared with a sample's. [Williams78]

Against false shadows: a bias that grows with the slope of what the texel shows ([OpenGL03] glPolygonOffset), and
surface numbers ([Hourcade85]): a texel that shows the sample's own plane never shadows it. Against jagged edges:
percentage closer filtering ([Reeves87]): the share of a block of texels that shadow the sample.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.scene.mesh import Mesh
from archsim.shadow.occluders import Occluders

NOTHING = -1
_SAME_PLANE = 1e-4  # of the scene's size and of a unit normal: triangles nearer than this lie in one plane


class ShadowMap(NamedTuple):
    """What the light sees at texel centres; row 0 is the first in logical cells."""

    depth: np.ndarray  # float32 [rows, columns] nearest depth, infinite where there is nothing
    triangle: np.ndarray  # int32 [rows, columns] index in Setup, or NOTHING


class Surfaces(NamedTuple):
    """What lookups need of the triangles in Setup."""

    slope: np.ndarray  # float32 [n] largest change of depth from texel to texel
    plane: np.ndarray  # int32 [n] number of the plane that the triangle lies in


class Receivers(NamedTuple):
    """Samples that ask whether they are in shadow."""

    position: np.ndarray  # float32 [n, 3] x and y in texels, depth; NaN where there is no sample
    plane: np.ndarray  # int32 [n] number of the plane that the sample lies in


class Lookup(NamedTuple):
    """How a map is asked."""

    radius: int  # texels around the nearest one that are asked too: 0 the nearest alone, 1 a block of 3 x 3
    slope_factor: float  # bias in slopes of the texel's triangle
    constant: float  # bias in depths
    own_plane_lights: bool  # texels that show the sample's own plane do not shadow it


@njit
def render(occluders, columns, rows):
    """The ShadowMap of triangles whose setup is in texels."""
    depth = np.full((rows, columns), np.float32(np.inf))
    triangle = np.full((rows, columns), np.int32(NOTHING))
    edges, bounds = occluders.setup.edges, occluders.setup.bounds
    for index in range(len(edges)):
        first_x = np.int64(min(max(bounds[index, 0] - 0.5, 0.0), columns))
        first_y = np.int64(min(max(bounds[index, 1] - 0.5, 0.0), rows))
        end_x = np.int64(min(max(bounds[index, 2] + 0.5, 0.0), columns))
        end_y = np.int64(min(max(bounds[index, 3] + 0.5, 0.0), rows))
        plane = occluders.depth[index]
        for j in range(first_y, end_y):
            for i in range(first_x, end_x):
                x, y = i + 0.5, j + 0.5
                if not _covers(edges[index], x, y):
                    continue
                here = np.float32(plane[0] * x + plane[1] * y + plane[3])
                if here < depth[j, i] and here < 1:  # 1 and beyond: behind the light
                    depth[j, i] = here
                    triangle[j, i] = index
    return ShadowMap(depth, triangle)


@njit
def _covers(edges, x, y):
    for k in range(3):
        if edges[k, 0] * x + edges[k, 1] * y + edges[k, 2] < 0:
            return False
    return True


def surfaces(occluders: Occluders, planes: np.ndarray) -> Surfaces:
    """`planes`: number of each mesh triangle's plane."""
    slope = np.abs(occluders.depth[:, :2]).max(axis=1) if len(occluders.depth) else np.empty(0, np.float32)
    return Surfaces(slope.astype(np.float32), planes[occluders.setup.triangle])


def plane_numbers(mesh: Mesh) -> np.ndarray:
    """int32 [num_triangles]: equal for triangles of one plane, whichever side they face."""
    corners = mesh.vertices.astype(np.float64)[mesh.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.where(length > 0, length, 1.0)
    leading = np.take_along_axis(normal, np.abs(normal).argmax(axis=1)[:, None], axis=1)
    normal = normal * np.where(leading < 0, -1.0, 1.0)
    size = float(np.abs(corners).max()) or 1.0
    offset = np.einsum("nk,nk->n", normal, corners.mean(axis=1)) / size
    quantised = np.round(np.column_stack([normal, offset]) / _SAME_PLANE).astype(np.int64)
    return np.unique(quantised, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int32)


@njit
def shadowed(shadow_map, map_surfaces, receivers, lookup):
    """float32 [n]: share of the texels asked that shadow the sample; 0 where there is no sample."""
    share = np.zeros(len(receivers.position), np.float32)
    for sample in range(len(share)):
        x, y, depth = receivers.position[sample]
        if np.isnan(x):
            continue
        share[sample] = share_at(shadow_map, map_surfaces, (x, y, depth), receivers.plane[sample], lookup)
    return share


@njit
def share_at(shadow_map, map_surfaces, position, plane, lookup):
    """Share of the texels around a position that shadow what is there."""
    rows, columns = shadow_map.depth.shape
    i, j = np.int64(np.floor(position[0])), np.int64(np.floor(position[1]))
    num_asked, num_shadowing = 0, 0
    for row in range(max(j - lookup.radius, 0), min(j + lookup.radius + 1, rows)):
        for column in range(max(i - lookup.radius, 0), min(i + lookup.radius + 1, columns)):
            num_asked += 1
            triangle = shadow_map.triangle[row, column]
            if triangle == NOTHING or (lookup.own_plane_lights and map_surfaces.plane[triangle] == plane):
                continue
            bias = lookup.slope_factor * map_surfaces.slope[triangle] + lookup.constant
            num_shadowing += shadow_map.depth[row, column] + bias < position[2]
    return num_shadowing / max(num_asked, 1)
