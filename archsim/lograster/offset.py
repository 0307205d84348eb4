"""Polygon offset against false self-shadowing, generalized to logarithmic rows. [Lloyd07] sec. 4.2.5

The offset is scale x m_z + units, where m_z is the larger slope of depth along a column and along a row of
the map. Along a logarithmic column the slope |dz/dy'| falls linearly with y, so it can fall below |dz/dx|
within one triangle: the
*switch*. Both are planes over the linear (x, y), so every treatment still interpolates with planes.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from archsim.jit import njit
from archsim.lograster.setup import DepthPlane, depth_at


class Switch(IntEnum):
    """What becomes of a triangle whose larger slope changes inside it."""

    INTERPOLATED = 0  # one plane: m_z linear between its values at the least and greatest y [Lloyd07] eq. 14
    TWO_PLANES = 1  # two planes, the larger at each sample
    SPLIT = 2  # one plane on each side of the row of the switch


class OffsetSpec(NamedTuple):
    """How much to offset."""

    scale: float  # of m_z
    units: float  # in depth
    switch: int  # Switch


class Slopes(NamedTuple):
    """Slopes of depth, per texel, at a map of given size: m_z is max(across, along + along_y y)."""

    across: float  # |dz/dx|
    along: float  # |dz/dy'| at y = 0 [Lloyd07] eq. 13
    along_y: float  # its change with y, <= 0


class OffsetDepth(NamedTuple):
    """Depth with its offset: `low` for y < `switch_y`, `high` from there on; or the larger of the two
    everywhere.
    """

    low: DepthPlane
    high: DepthPlane
    switch_y: float
    larger: bool


@njit
def slopes(plane, columns, rows, steepness):
    """Slopes of a depth plane; `steepness` is (dy/dy' at y = 0, its change with y)."""
    along = abs(plane.dy) / rows
    return Slopes(abs(plane.dx) / columns, along * steepness[0], along * steepness[1])


@njit
def larger_slope(slopes, y):
    """m_z at y. [Lloyd07] eq. 12"""
    return max(slopes.across, slopes.along + slopes.along_y * y)


@njit
def switch_position(slopes):
    """The y at which both slopes are equal; above 1 where they never are."""
    if slopes.along <= slopes.across:
        return 0.0
    if slopes.along + slopes.along_y >= slopes.across:
        return 2.0
    return (slopes.across - slopes.along) / slopes.along_y


@njit
def offset_depth(plane, slopes, y0, y1, spec):
    """OffsetDepth of a triangle that reaches from y0 to y1, both within [0, 1]."""
    if spec.switch == Switch.INTERPOLATED:
        at_y0, at_y1 = larger_slope(slopes, y0), larger_slope(slopes, y1)
        change = (at_y1 - at_y0) / (y1 - y0) if y1 > y0 else 0.0
        single = _raised(plane, spec, at_y0 - change * y0, change)
        return OffsetDepth(single, single, 0.0, False)
    low = _raised(plane, spec, slopes.along, slopes.along_y)
    high = _raised(plane, spec, slopes.across, 0.0)
    return OffsetDepth(low, high, switch_position(slopes), spec.switch == Switch.TWO_PLANES)


@njit
def _raised(plane, spec, slope, change):
    """The plane plus scale x (slope + change y) + units; its limits make room for the largest offset in the
    map.
    """
    most = spec.scale * max(slope, slope + change) + spec.units
    return DepthPlane(
        plane.constant + spec.scale * slope + spec.units,
        plane.dx,
        plane.dy + spec.scale * change,
        plane.low + min(most, 0.0),
        plane.high + max(most, 0.0),
    )


@njit
def offset_depth_at(depth, x, y):
    """Depth with offset at a place in the map."""
    if depth.larger:
        return max(depth_at(depth.low, x, y), depth_at(depth.high, x, y))
    return depth_at(depth.low if y < depth.switch_y else depth.high, x, y)


@njit
def excess(slopes, y0, y1):
    """How far the interpolated m_z exceeds the true one at most, relative to it: 0 without a switch in (y0,
    y1).

    The true m_z falls and then stays level, so the straight line is above it, and most so at the switch.
    """
    y = switch_position(slopes)
    if not y0 < y < y1 or slopes.across == 0.0:
        return 0.0
    part = (y - y0) / (y1 - y0)
    line = larger_slope(slopes, y0) * (1.0 - part) + larger_slope(slopes, y1) * part
    return line / slopes.across - 1.0
