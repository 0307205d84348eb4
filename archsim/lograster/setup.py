"""Triangle setup: snapped corners, exact edge functions, and the plane of depth. [Lloyd07] sec. 4.1, 4.2

An edge function a x + b y + c is a whole number at every sample, computed without rounding: |a|, |b| < 2^29,
|c| < 2^58 at 24 bits. A triangle owns the samples where all three are >= 0. On an edge itself that holds for
one of the two triangles beside it only: c of the other one is 1 less.
"""

from __future__ import annotations

from typing import NamedTuple

from archsim.jit import njit


class Edges(NamedTuple):
    """Three edge functions: triangle where a[i] x + b[i] y + c[i] >= 0 for all i."""

    a: tuple[int, int, int]
    b: tuple[int, int, int]
    c: tuple[int, int, int]
    area: int  # twice the triangle's, in grid units squared; 0: it covers nothing


class DepthPlane(NamedTuple):
    """Depth over the linear (x, y) of the map, each in [0, 1]: constant + dx x + dy y, kept in [low, high]."""

    constant: float
    dx: float
    dy: float
    low: float  # least and greatest depth of the corners: samples that snapping moved out get no wild depths
    high: float


@njit
def snap(position, bits):
    """The whole coordinate nearest to a position given in map sizes."""
    scaled = position * float(1 << bits) + 0.5
    whole = int(scaled)
    return whole - 1 if whole > scaled else whole


@njit
def edge_functions(x, y):
    """Edges of a triangle with whole corner coordinates x[3], y[3], whichever way round it is."""
    area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    turn = 1 if area >= 0 else -1
    a0, b0, c0 = _edge(x[0], y[0], x[1], y[1], turn)
    a1, b1, c1 = _edge(x[1], y[1], x[2], y[2], turn)
    a2, b2, c2 = _edge(x[2], y[2], x[0], y[0], turn)
    return Edges((a0, a1, a2), (b0, b1, b2), (c0, c1, c2), turn * area)


@njit
def _edge(x0, y0, x1, y1, turn):
    """(a, b, c) of the edge from corner 0 to 1. A sample on it is owned as if it lay at (+0, +0 squared) from
    there.
    """
    a = turn * (y0 - y1)
    b = turn * (x1 - x0)
    c = turn * (x0 * y1 - x1 * y0)
    if a > 0 or (a == 0 and b > 0):
        return a, b, c
    return a, b, c - 1


@njit
def depth_plane(x, y, z):
    """DepthPlane through three corners, float64; flat where the corners span no area."""
    x1, y1, z1 = x[1] - x[0], y[1] - y[0], z[1] - z[0]
    x2, y2, z2 = x[2] - x[0], y[2] - y[0], z[2] - z[0]
    area = x1 * y2 - x2 * y1
    low, high = min(z[0], z[1], z[2]), max(z[0], z[1], z[2])
    if area == 0.0:
        return DepthPlane(low, 0.0, 0.0, low, high)
    dx = (z1 * y2 - z2 * y1) / area
    dy = (z2 * x1 - z1 * x2) / area
    return DepthPlane(z[0] - dx * x[0] - dy * y[0], dx, dy, low, high)


@njit
def depth_at(plane, x, y):
    """Depth of the plane at a place in the map."""
    return min(max(plane.constant + plane.dx * x + plane.dy * y, plane.low), plane.high)
