"""Draws a mesh into a fitted shadow map."""

from __future__ import annotations

import numpy as np

from archsim.lograster.depth_buffer import NO_OFFSET, Drawn, draw
from archsim.lograster.grid import BITS, make_grid
from archsim.lograster.offset import OffsetSpec
from archsim.scene.mesh import Mesh
from archsim.shadowmap.fit import ShadowMap, with_one


def map_vertices(mesh: Mesh, shadow_map: ShadowMap) -> np.ndarray:
    """The mesh's vertices in a map, (x, y, z, w) float64 [n, 4]; y before the logarithm."""
    return np.ascontiguousarray(with_one(mesh.vertices.astype(np.float64)) @ shadow_map.matrix.T)


def render(
    mesh: Mesh,
    shadow_map: ShadowMap,
    size: tuple[int, int],
    offset: OffsetSpec = NO_OFFSET,
    bits: int = BITS,
) -> Drawn:
    """The depths of a mesh in a map of (columns, rows) texels."""
    grid = make_grid(*size, shadow_map.ratio, bits)
    return draw(map_vertices(mesh, shadow_map), mesh.triangles, grid, offset)
