"""Shadow volumes as a view sees them, and what every way of drawing them needs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from archsim.shadow_volumes.footprint import Footprint, new_footprint
from archsim.shadow_volumes.polygon import Polygon, new_polygon
from archsim.shadow_volumes.tiles import Screen
from archsim.shadow_volumes.volumes import Volumes


class Space(NamedTuple):
    """Room for one polygon at a time."""

    polygon: Polygon
    footprint: Footprint


class SeenVolumes(NamedTuple):
    """Volumes as the view sees them."""

    volumes: Volumes
    points: np.ndarray  # float64 [num_points, 4] of `seen_by`
    bounds: np.ndarray  # float64 [num_volumes, 2] depth bounds, as closeness; (0, inf) for none
    screen: Screen


Steps = Callable[[int], Iterable[tuple[int, int]]]  # of n volumes: half-open ranges that make up 0 ... n


def at_once(number: int) -> list[tuple[int, int]]:
    """All volumes in one step."""
    return [(0, number)]


def new_space(screen: Screen) -> Space:
    return Space(new_polygon(), new_footprint(screen))
