"""The triangles of an object that a shadow volume starts from, and the edges that bound them.

The light cap is a set of triangles, each turned to the light. An edge that the cap uses k more times in one direction
than in the other is a silhouette edge and needs |k| side quads; so the volume is closed whatever the mesh is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.shadow_volumes.casters import Casters


class Cap(NamedTuple):
    """Light caps of all objects."""

    triangles: np.ndarray  # int64 [n, 3] vertices, counterclockwise as seen from the light
    caster: np.ndarray  # int64 [n] rising


class Silhouette(NamedTuple):
    """Directed edges a -> b as the light cap uses them, in chains; an edge of net use k is there k times."""

    start: np.ndarray  # int64 [n] vertices
    end: np.ndarray  # int64 [n]
    caster: np.ndarray  # int64 [n] rising


def light_cap(casters: Casters, light: np.ndarray) -> Cap:
    """The cap of every object.

    Of a closed part that the light is outside of, the triangles that face the light are enough: whatever crosses the
    part to get to the light crosses one of them. Of any other part all triangles are taken.
    """
    corners = casters.positions[casters.triangles] - light
    facing = np.einsum("nk,nk->n", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2])
    facing = -facing  # of the tetrahedron (light, a, b, c): positive where the light is on the normal's side
    outwards = _outward(casters, corners)

    part_facing = facing * outwards
    taken = np.where(outwards != 0, part_facing > 0, facing != 0)
    turned = np.where(facing[:, None] > 0, casters.triangles, casters.triangles[:, ::-1])
    return Cap(turned[taken], casters.caster[taken])


def silhouette(cap: Cap) -> Silhouette:
    """The edges that bound each cap."""
    start, end, caster = net_edges(cap.triangles, cap.caster)
    order = np.lexsort((end, start, caster))
    start, end, caster = start[order], end[order], caster[order]
    chain = _chained(start, end, caster)
    return Silhouette(start[chain], end[chain], caster[chain])


def net_edges(triangles: np.ndarray, label: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(a, b, label) of the directed edges that triangles of one label use more often than b -> a, as often as more."""
    a = triangles.ravel()
    b = triangles[:, [1, 2, 0]].ravel()
    label = np.repeat(label, 3)
    low, high, sign = np.minimum(a, b), np.maximum(a, b), np.where(a < b, 1, -1)
    order = np.lexsort((high, low, label))
    low, high, label = low[order], high[order], label[order]
    if not len(order):
        return low, high, label
    new = np.ones(len(order), bool)
    new[1:] = (low[1:] != low[:-1]) | (high[1:] != high[:-1]) | (label[1:] != label[:-1])
    first = np.flatnonzero(new)
    net = np.add.reduceat(sign[order], first)
    uses = np.abs(net).astype(np.int64)

    low, high, label = low[first], high[first], label[first]
    a, b = np.where(net > 0, low, high), np.where(net > 0, high, low)
    return np.repeat(a, uses), np.repeat(b, uses), np.repeat(label, uses)


def _outward(casters: Casters, corners: np.ndarray) -> np.ndarray:
    """+1 or -1 [num_triangles]: the normal, or its opposite, points out of the closed part; 0 where a part is not
    closed or surrounds the light. `corners` are relative to the light."""
    names, part = np.unique(casters.part, return_inverse=True)
    part = part.ravel()
    is_open = np.zeros(len(names), bool)
    is_open[net_edges(casters.triangles, part)[2]] = True

    volume = np.bincount(part, _volumes(corners, casters, part), len(names))
    turns = np.bincount(part, _solid_angles(corners), len(names)) / (4 * np.pi)
    outward = np.sign(volume)
    outward[is_open | (np.abs(turns) > 0.25)] = 0
    return outward[part]


def _volumes(corners: np.ndarray, casters: Casters, part: np.ndarray) -> np.ndarray:
    """Signed volume under each triangle, seen from a corner of its part, so that distant parts keep their sign."""
    _, first = np.unique(part, return_index=True)
    local = corners - corners[first, 0][part][:, None]
    return np.einsum("nk,nk->n", np.cross(local[:, 0], local[:, 1]), local[:, 2])


def _solid_angles(corners: np.ndarray) -> np.ndarray:
    """Signed solid angle of each triangle as seen from the origin (Van Oosterom, Strackee 1983)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    x, y, z = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    above = np.einsum("nk,nk->n", np.cross(a, b), c)
    ab, bc, ca = (np.einsum("nk,nk->n", p, q) for p, q in ((a, b), (b, c), (c, a)))
    return np.asarray(2 * np.arctan2(above, x * y * z + ab * z + bc * x + ca * y))


@njit
def _chained(start, end, caster):
    """An order of the edges, sorted by (caster, start), in which each goes on where the one before it ended."""
    order = np.empty(len(start), np.int64)
    used = np.zeros(len(start), np.bool_)
    num = 0
    for first in range(len(start)):
        edge = first
        while edge >= 0 and not used[edge]:
            used[edge] = True
            order[num] = edge
            num += 1
            edge = _following(start, caster, used, caster[edge], end[edge])
    return order


@njit
def _following(start, caster, used, wanted_caster, wanted_start):
    """An unused edge of the object that starts there, or -1."""
    low, high = 0, len(start)
    while low < high:
        middle = (low + high) // 2
        if caster[middle] < wanted_caster or (
            caster[middle] == wanted_caster and start[middle] < wanted_start
        ):
            low = middle + 1
        else:
            high = middle
    while low < len(start) and caster[low] == wanted_caster and start[low] == wanted_start:
        if not used[low]:
            return low
        low += 1
    return -1
