"""Which triangles cast shadows together: the objects, connected parts or single triangles of a mesh."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.scene.mesh import Mesh


class Grouping(IntEnum):
    """What makes one shadow-casting object, and so one shadow volume."""

    OBJECTS = 0  # what the mesh names as objects; its parts if it names none
    PARTS = 1  # triangles that are connected by vertices at the same place
    WHOLE = 2  # all triangles together: "a single triangle soup"
    TRIANGLES = 3  # each triangle by itself


class Casters(NamedTuple):
    """Triangles with their objects; vertices at the same place are one vertex."""

    positions: np.ndarray  # float64 [num_vertices, 3]
    triangles: np.ndarray  # int64 [num_triangles, 3] of those that cast shadows, object after object
    caster: np.ndarray  # int64 [num_triangles] object of each triangle, rising
    part: np.ndarray  # int64 [num_triangles] connected part of the object
    num_casters: int


def find_casters(mesh: Mesh, grouping: Grouping = Grouping.OBJECTS) -> Casters:
    """The shadow-casting objects of a mesh by first triangle; degenerate triangles are left out."""
    positions, triangles = welded(mesh)
    objects = np.zeros(len(triangles), np.int64) if mesh.objects is None else mesh.objects.astype(np.int64)
    a, b, c = triangles.T
    casting = np.flatnonzero((objects >= 0) & (a != b) & (b != c) & (c != a))
    triangles, objects = triangles[casting], objects[casting]

    part = connected_parts(triangles, objects, len(positions))
    if grouping == Grouping.WHOLE:
        caster = np.zeros(len(casting), np.int64)
    elif grouping == Grouping.TRIANGLES:
        caster = np.arange(len(casting))
    elif grouping == Grouping.PARTS or mesh.objects is None:
        caster = part
    else:
        caster = objects
    caster = _by_first_use(caster)
    order = np.argsort(caster, kind="stable")
    if grouping == Grouping.TRIANGLES:
        part = caster
    num_casters = int(caster.max(initial=-1)) + 1
    return Casters(positions, triangles[order], caster[order], part[order], num_casters)


def welded(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Distinct positions float64 [n, 3] and triangles int64 [m, 3] that index them."""
    positions = mesh.vertices.astype(np.float64) + 0.0  # no negative zeros
    order = np.lexsort(positions.T)
    new = np.ones(len(order), bool)
    new[1:] = (positions[order[1:]] != positions[order[:-1]]).any(axis=1)
    index = np.empty(len(order), np.int64)
    index[order] = np.cumsum(new) - 1
    return positions[order[new]], index[mesh.triangles]


def connected_parts(triangles: np.ndarray, objects: np.ndarray, num_vertices: int) -> np.ndarray:
    """int64 [num_triangles]: numbers of parts; triangles of an object that share a vertex are in one part."""
    key = objects[:, None] * num_vertices + triangles
    corners, index = np.unique(key, return_inverse=True)
    return _roots(index.reshape(-1, 3), len(corners))


def _by_first_use(labels: np.ndarray) -> np.ndarray:
    """Labels renumbered 0, 1, 2 ... in the order in which they first occur."""
    _, first, index = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[index.ravel()]


@njit
def _roots(triangles, num_vertices):
    """The part of each triangle, named by one of its vertices: union-find with path halving."""
    parent = np.arange(num_vertices)
    for index in range(len(triangles)):
        root = _root(parent, triangles[index, 0])
        for corner in range(1, 3):
            parent[_root(parent, triangles[index, corner])] = root
    part = np.empty(len(triangles), np.int64)
    for index in range(len(triangles)):
        part[index] = _root(parent, triangles[index, 0])
    return part


@njit
def _root(parent, vertex):
    while parent[vertex] != vertex:
        parent[vertex] = parent[parent[vertex]]
        vertex = parent[vertex]
    return vertex
