"""Conservative rasterization: every cell that a triangle overlaps gets a grid fragment. [Johnson04] sec. 5.1

Triangles are given by homogeneous edge functions ([Olano97]), so no clipping against the light plane is needed: a
triangle that crosses it is tested against every cell of the viewport.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit


class Viewport(NamedTuple):
    """Half-open range of cells that hold samples; rasterization is clipped to it."""

    i0: int
    j0: int
    i1: int
    j1: int


class Setup(NamedTuple):
    """Triangles ready for rasterization, in submission order."""

    triangle: np.ndarray  # int32 [n] index in the mesh
    edges: np.ndarray  # float64 [n, 3, 3] (a, b, c): inside where a x + b y + c >= 0
    bounds: (
        np.ndarray
    )  # float64 [n, 4] x0, y0, x1, y1 of the projection, infinite where it crosses the light plane


class GridFragments(NamedTuple):
    """Cells overlapped by triangles: triangle after triangle, each in tile order."""

    setup_index: np.ndarray  # int32 [n] index in Setup
    i: np.ndarray  # int32 [n] cell column
    j: np.ndarray  # int32 [n] cell row
    num_before_stencil: int  # fragments that the stencil test saw


def rasterize(setup: Setup, stencil: np.ndarray, tile: tuple[int, int], margin: float) -> GridFragments:
    """Grid fragments of all triangles that pass the stencil (bool [rows, columns]), clipped to its populated range.

    A cell counts as overlapped when the triangle comes within `margin` cells of it, so that rounding loses no sample.
    """
    viewport = populated(stencil)
    nothing = np.empty(0, np.int32)
    num_before, num_after = _walk(setup, stencil, viewport, tile, margin, (nothing, nothing, nothing))
    out = (np.empty(num_after, np.int32), np.empty(num_after, np.int32), np.empty(num_after, np.int32))
    _walk(setup, stencil, viewport, tile, margin, out)
    return GridFragments(*out, num_before)


def populated(stencil: np.ndarray) -> Viewport:
    """The smallest range that holds every marked cell; empty if there is none."""
    rows, columns = np.flatnonzero(stencil.any(axis=1)), np.flatnonzero(stencil.any(axis=0))
    if not len(rows):
        return Viewport(0, 0, 0, 0)
    return Viewport(int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1)


@njit
def _walk(setup, stencil, viewport, tile, margin, out):
    """Visit every overlapped cell in order; (cells, cells that pass the stencil). Those that fit go to `out`."""
    num_before = 0
    num_after = 0
    for index in range(len(setup.triangle)):
        edges = setup.edges[index]
        box = _box(setup.bounds[index], viewport, margin)
        for tile_j in range(box.j0 // tile[1], (box.j1 - 1) // tile[1] + 1):
            for tile_i in range(box.i0 // tile[0], (box.i1 - 1) // tile[0] + 1):
                part = _clip(box, tile_i * tile[0], tile_j * tile[1], tile)
                if not _overlaps(edges, part, margin):
                    continue
                for j in range(part.j0, part.j1):
                    for i in range(part.i0, part.i1):
                        if not _overlaps(edges, Viewport(i, j, i + 1, j + 1), margin):
                            continue
                        num_before += 1
                        if stencil[j, i]:
                            if num_after < len(out[0]):
                                out[0][num_after] = index
                                out[1][num_after] = i
                                out[2][num_after] = j
                            num_after += 1
    return num_before, num_after


@njit
def _box(bounds, viewport, margin):
    """Cells of the viewport that the triangle's bounds meet."""
    i0 = max(viewport.i0, np.int64(np.ceil(max(bounds[0] - margin, viewport.i0 - 1.0))) - 1)
    j0 = max(viewport.j0, np.int64(np.ceil(max(bounds[1] - margin, viewport.j0 - 1.0))) - 1)
    i1 = min(viewport.i1, np.int64(np.floor(min(bounds[2] + margin, viewport.i1 + 1.0))) + 1)
    j1 = min(viewport.j1, np.int64(np.floor(min(bounds[3] + margin, viewport.j1 + 1.0))) + 1)
    if i0 >= i1 or j0 >= j1:
        return Viewport(0, 0, 0, 0)
    return Viewport(i0, j0, i1, j1)


@njit
def _clip(box, i0, j0, tile):
    """The part of the box in the tile whose first cell is (i0, j0)."""
    return Viewport(max(box.i0, i0), max(box.j0, j0), min(box.i1, i0 + tile[0]), min(box.j1, j0 + tile[1]))


@njit
def _overlaps(edges, cells, margin):
    """Whether a block of cells, grown by `margin`, meets the inner side of all three edges."""
    x, y = 0.5 * (cells.i0 + cells.i1), 0.5 * (cells.j0 + cells.j1)
    half_x, half_y = 0.5 * (cells.i1 - cells.i0) + margin, 0.5 * (cells.j1 - cells.j0) + margin
    for k in range(3):
        a, b, c = edges[k, 0], edges[k, 1], edges[k, 2]
        if a * x + b * y + c + abs(a) * half_x + abs(b) * half_y < 0.0:
            return False
    return True
