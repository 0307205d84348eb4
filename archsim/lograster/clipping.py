"""Clipping to the guard band around a map, and snapping to its coordinate grid.

Vertices are (x, y, z, w): (x/w, y/w) is the place in the map, linear in y, and z/w the depth. What lies at w
<= 0 cannot be seen by the light; what lies far outside would overflow the fixed-point edge functions. Equal
edges are cut at equal points whichever way they run, so that triangles that share an edge still share it
afterwards.
"""

from __future__ import annotations

from archsim.jit import njit

GUARD = 4.0  # how far outside the map coordinates may lie, in map sizes
MOST_CORNERS = 8  # of a triangle cut by five planes


@njit
def clip(corners, least_w, out, spare):
    """Cut a triangle, float64 [3, 4], to w >= `least_w` and the guard band; the polygon goes to `out`
    [MOST_CORNERS, 4].

    Returns its number of corners, 0 where nothing is left. `least_w` > 0 has to be the same for all triangles
    of a mesh. `spare` is room of the same shape.
    """
    for i in range(3):
        for k in range(4):
            out[i, k] = corners[i, k]
    num = 3
    for plane in range(5):
        if not _cuts(out, num, plane, least_w):
            continue
        num = _cut(out, num, plane, least_w, spare)
        for i in range(num):
            for k in range(4):
                out[i, k] = spare[i, k]
        if num == 0:
            return 0
    return num


@njit
def _distance(corner, plane, least_w):
    """How far a corner is inside a plane of the guard band; w first, which the others rely on."""
    if plane == 0:
        return corner[3] - least_w
    if plane == 1:
        return corner[0] + GUARD * corner[3]
    if plane == 2:
        return (1 + GUARD) * corner[3] - corner[0]
    if plane == 3:
        return corner[1] + GUARD * corner[3]
    return (1 + GUARD) * corner[3] - corner[1]


@njit
def _cuts(polygon, num, plane, least_w):
    for i in range(num):
        if _distance(polygon[i], plane, least_w) < 0:
            return True
    return False


@njit
def _cut(polygon, num, plane, least_w, out):
    """The part of the polygon inside a plane, into `out`; returns its number of corners."""
    kept = 0
    for i in range(num):
        here, there = polygon[i], polygon[(i + 1) % num]
        inside, next_inside = _distance(here, plane, least_w), _distance(there, plane, least_w)
        if inside >= 0:
            for k in range(4):
                out[kept, k] = here[k]
            kept += 1
        if (inside >= 0) != (next_inside >= 0):
            _crossing(here, there, inside, next_inside, out[kept])
            kept += 1
    return kept


@njit
def _crossing(a, b, distance_a, distance_b, out):
    """Where the edge a b meets the plane; the same numbers for b a."""
    if _comes_first(b, a):
        a, b = b, a
        distance_a, distance_b = distance_b, distance_a
    part = distance_a / (distance_a - distance_b)
    for k in range(4):
        out[k] = a[k] + part * (b[k] - a[k])


@njit
def _comes_first(a, b):
    for k in range(4):
        if a[k] != b[k]:
            return a[k] < b[k]
    return False
