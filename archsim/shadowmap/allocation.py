"""How many texels each map gets, and how many are needed. [Lloyd07] sec. 3.1, step 2"""

from __future__ import annotations

import math

import numpy as np

from archsim.lograster.grid import MOST_SAMPLES, TILE
from archsim.shadowmap.error import owner, space_error
from archsim.shadowmap.families import BALANCED
from archsim.shadowmap.fit import ShadowMap
from archsim.shadowmap.view import View, volume_samples


def needed(maps: list[ShadowMap], view: View, rows: int) -> np.ndarray:
    """Columns and rows, float64 [maps, 2], at which no map's texel is larger than a pixel anywhere in the
    view.
    """
    points = volume_samples(view)
    owners = owner(maps, points)
    sizes = np.zeros((len(maps), 2))
    for index, shadow_map in enumerate(maps):
        mine = points[owners == index]
        if len(mine):
            sizes[index] = [error.max() for error in space_error(shadow_map, view, mine, rows)]
    return sizes


def balanced(sizes: np.ndarray, texels: int) -> list[tuple[int, int]]:
    """Share texels so that the largest error is the same in all maps, across and along: the needed sizes,
    scaled alike.
    """
    scale = math.sqrt(texels / sizes.prod(axis=1).sum())
    return [(_whole(columns * scale), _whole(rows * scale)) for columns, rows in sizes]


def equal(num_maps: int, texels: int) -> list[tuple[int, int]]:
    """The same square for every map."""
    side = _whole(math.sqrt(texels / num_maps))
    return [(side, side)] * num_maps


def sizes_of(
    family: str, maps: list[ShadowMap], view: View, image_rows: int, texels: int
) -> list[tuple[int, int]]:
    """(columns, rows) of each map of a family that share so many texels."""
    if family in BALANCED:
        return balanced(needed(maps, view, image_rows), texels)
    return equal(len(maps), texels)


def _whole(size: float) -> int:
    """The nearest whole number of tiles, at least one."""
    return min(MOST_SAMPLES, max(1, round(size / TILE)) * TILE)
