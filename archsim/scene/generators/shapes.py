"""Closed solids and grids that generators put together; float64, outward sides counterclockwise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from archsim.scene.mesh import Mesh

BOX_TRIANGLES = 12


NO_SHADOW = -1


def join(parts: Sequence[Mesh], objects: Sequence[int] | None = None) -> Mesh:
    """All parts as one mesh, in order, in its final types; `objects`: whose shadow each part is of, or NO_SHADOW."""
    firsts = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    triangles = [part.triangles + first for part, first in zip(parts, firsts, strict=True)]
    return Mesh(
        np.concatenate([part.vertices for part in parts]).astype(np.float32),
        np.concatenate(triangles).astype(np.int32),
        None if objects is None else np.repeat(np.array(objects, np.int32), [len(t) for t in triangles]),
    )


def boxes(lows: np.ndarray, highs: np.ndarray) -> Mesh:
    """Boxes along the axes from `lows` to `highs`, float [n, 3]: 12 triangles each."""
    sides = np.array([[index >> axis & 1 for axis in range(3)] for index in range(8)], dtype=bool)
    vertices = np.where(sides, np.asarray(highs)[:, None], np.asarray(lows)[:, None])
    walls = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = np.array([corners for a, b, c, d in walls for corners in ((a, b, c), (a, c, d))])
    return Mesh(vertices.reshape(-1, 3), _instances(triangles, len(vertices), 8))


def _instances(triangles: np.ndarray, copies: int, num_vertices: int) -> np.ndarray:
    """Triangles of copies of one solid whose vertices follow each other."""
    firsts = np.arange(copies) * num_vertices
    return np.asarray((firsts[:, None, None] + triangles).reshape(-1, 3))


def sphere_triangles(slices: int, stacks: int) -> int:
    """Triangles of `spheres`, each."""
    return 2 * slices * (stacks - 1)


def spheres(centres: np.ndarray, radii: np.ndarray, slices: int, stacks: int) -> Mesh:
    """Spheres with poles up and down: stacks - 1 rings of `slices` vertices each."""
    one = unit_sphere(slices, stacks)
    vertices = np.asarray(centres)[:, None] + np.asarray(radii)[:, None, None] * one.vertices
    return Mesh(vertices.reshape(-1, 3), _instances(one.triangles, len(vertices), len(one.vertices)))


def unit_sphere(slices: int, stacks: int) -> Mesh:
    """Two poles and stacks - 1 rings of `slices` vertices: 2 slices (stacks - 1) triangles."""
    polar, azimuth = np.meshgrid(
        np.arange(1, stacks) * (np.pi / stacks), np.arange(slices) * (2 * np.pi / slices), indexing="ij"
    )
    rings = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    )
    vertices = np.concatenate([rings.reshape(-1, 3), [(0, 0, 1), (0, 0, -1)]])

    one = np.arange(slices)
    other = (one + 1) % slices
    north, south, last = len(vertices) - 2, len(vertices) - 1, (stacks - 2) * slices
    caps = [
        np.stack([np.full(slices, north), one, other], axis=1),
        np.stack([np.full(slices, south), last + other, last + one], axis=1),
    ]
    between = closed_grid(stacks - 1, slices)[: 2 * slices * (stacks - 2)]
    return Mesh(vertices, np.concatenate([caps[0], between, caps[1]]))


def closed_grid(rows: int, columns: int) -> np.ndarray:
    """Triangles [2 rows columns, 3] of a grid of quads that closes in both directions."""
    row, column = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    next_row, next_column = (row + 1) % rows, (column + 1) % columns
    a, b = row * columns + column, next_row * columns + column
    c, d = next_row * columns + next_column, row * columns + next_column
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def tube_triangles(num_points: int, sides: int) -> int:
    """Triangles of `tubes`, each."""
    return 2 * sides * (num_points - 1) + 2 * sides


def tubes(points: np.ndarray, radii: np.ndarray, sides: int) -> Mesh:
    """Closed tubes along polylines, float [n, num_points, 3], with a vertex in the middle of either end.

    Rings stand across the mean direction at their point and are turned alike, so that bends do not twist.
    """
    points, radii = np.asarray(points, dtype=np.float64), np.asarray(radii, dtype=np.float64)
    num_points = points.shape[1]
    steps = unit(np.diff(points, axis=1))
    directions = unit(np.concatenate([steps[:, :1], steps[:, :-1] + steps[:, 1:], steps[:, -1:]], axis=1))
    normals = _carried_along(directions)
    binormals = np.cross(directions, normals)
    angle = np.arange(sides) * (2 * np.pi / sides)
    rings = np.cos(angle)[:, None] * normals[:, :, None] + np.sin(angle)[:, None] * binormals[:, :, None]
    walls = points[:, :, None] + radii[:, None, None, None] * rings
    vertices = np.concatenate([walls.reshape(len(points), -1, 3), points[:, [0, -1]]], axis=1)

    wall = closed_grid(num_points, sides)[: 2 * sides * (num_points - 1), ::-1]
    one = np.arange(sides)
    other, start = (one + 1) % sides, (num_points - 1) * sides
    first, last = num_points * sides, num_points * sides + 1
    near_end = np.stack([np.full(sides, first), other, one], axis=1)
    far_end = np.stack([np.full(sides, last), start + one, start + other], axis=1)
    triangles = np.concatenate([wall, near_end, far_end])
    return Mesh(vertices.reshape(-1, 3), _instances(triangles, len(points), vertices.shape[1]))


def _carried_along(directions: np.ndarray) -> np.ndarray:
    """For each point of polylines a unit vector across its direction, the previous one turned as little as
    can be.
    """
    normals = np.zeros_like(directions)
    previous = np.eye(3)[np.argmin(np.abs(directions[:, 0]), axis=1)]
    for index in range(directions.shape[1]):
        direction = directions[:, index]
        previous = unit(previous - (previous * direction).sum(axis=1, keepdims=True) * direction)
        normals[:, index] = previous
    return normals


def ground(half_size: float, cells: int, heights: np.ndarray) -> Mesh:
    """A square of cells x cells quads around the origin, with heights [cells + 1, cells + 1] (y, x)."""
    line = np.linspace(-half_size, half_size, cells + 1)
    x, y = np.meshgrid(line, line)
    row, column = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
    a = row * (cells + 1) + column
    b, c, d = a + 1, a + cells + 2, a + cells + 1
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    return Mesh(np.stack([x, y, heights], axis=-1).reshape(-1, 3), triangles)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors [..., 3] at length 1."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
