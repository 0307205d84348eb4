"""The stencil buffer, and drawing into it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, inlined, njit
from archsim.shadow_volumes.footprint import CUTS
from archsim.shadow_volumes.polygon import closeness
from archsim.shadow_volumes.tiles import Screen, spread


class Stencil(NamedTuple):
    """A pixel's value is the sum of its own and its tile's; greater than 0 is shadow. Never wraps around.

    So are its layers, the number of its updates so far.
    """

    pixels: np.ndarray  # int32 [height, width]
    whole: np.ndarray  # int32 [num_tiles] of polygons that cover all of the tile
    layers: np.ndarray  # int32 [height, width]
    whole_layers: np.ndarray  # int32 [num_tiles]


def new_stencil(screen: Screen) -> Stencil:
    """A cleared stencil buffer."""
    size, num_tiles = (screen.height, screen.width), screen.rows * screen.columns
    return Stencil(*(np.zeros(shape, np.int32) for shape in (size, num_tiles, size, num_tiles)))


@compiled
def draw_tile(tile, relation, polygon, screen, stencil):
    """Draw a polygon, (footprint, extent, plane, z_pass), in one tile: (pixels updated, 1 if depths were needed)."""
    footprint, extent, plane, z_pass = polygon
    y0 = (tile // screen.columns) * screen.tile
    x0 = (tile % screen.columns) * screen.tile
    y1, x1 = min(y0 + screen.tile, screen.height), min(x0 + screen.tile, screen.width)
    first, end = max(y0, extent.first), min(y1, extent.end)
    if relation == CUTS:
        return _draw_tested(footprint, plane, z_pass, screen, stencil, (first, end, x0, x1))

    covered = 0
    for y in range(first, end):
        left, right = _span(footprint, y, x0, x1)
        covered += max(0, right - left)
    if covered == (x1 - x0) * (y1 - y0):
        stencil.whole[tile] += _weight(footprint, first, z_pass)
        stencil.whole_layers[tile] += 1
    elif covered > 0:
        for y in range(first, end):
            left, right = _span(footprint, y, x0, x1)
            weight = _weight(footprint, y, z_pass)
            for x in range(left, right):
                stencil.pixels[y, x] += weight
                stencil.layers[y, x] += 1
    return covered, 0


@inlined
def _draw_tested(footprint, plane, z_pass, screen, stencil, part):
    """Draw where the depth test passes."""
    first, end, x0, x1 = part
    updated = 0
    touched = 0
    for y in range(first, end):
        left, right = _span(footprint, y, x0, x1)
        weight = _weight(footprint, y, z_pass)
        for x in range(left, right):
            touched = 1
            if (closeness(plane, x, y) > screen.closest[y, x]) == z_pass:
                stencil.pixels[y, x] += weight
                stencil.layers[y, x] += 1
                updated += 1
    return updated, touched


@inlined
def _span(footprint, y, x0, x1):
    """Half-open range of the pixels of row y that are covered, within x0 ... x1."""
    growing, shrinking = footprint.growing[y], footprint.shrinking[y]
    return max(x0, min(growing, shrinking)), min(x1, max(growing, shrinking))


@inlined
def _weight(footprint, y, z_pass):
    """What a fragment of row y adds: Z-pass counts front faces up, Z-fail back faces."""
    is_front = footprint.growing[y] <= footprint.shrinking[y]
    return 1 if is_front == z_pass else -1


@compiled
def tile_extremes(tile, screen, stencil):
    """(lowest, highest) stencil value of a tile's pixels."""
    y0 = (tile // screen.columns) * screen.tile
    x0 = (tile % screen.columns) * screen.tile
    low, high = stencil.pixels[y0, x0], stencil.pixels[y0, x0]
    for y in range(y0, min(y0 + screen.tile, screen.height)):
        for x in range(x0, min(x0 + screen.tile, screen.width)):
            low, high = min(low, stencil.pixels[y, x]), max(high, stencil.pixels[y, x])
    return low + stencil.whole[tile], high + stencil.whole[tile]


@njit
def tile_ranges(tiles, screen, stencil):
    """int64 [n] lowest and highest stencil value of some tiles' pixels."""
    low, high = np.zeros(len(tiles), np.int64), np.zeros(len(tiles), np.int64)
    for place, tile in enumerate(tiles):
        low[place], high[place] = tile_extremes(tile, screen, stencil)
    return low, high


def values(screen: Screen, stencil: Stencil) -> np.ndarray:
    """int32 [height, width]: the stencil value of every pixel."""
    return stencil.pixels + spread(screen, stencil.whole)


def layers(screen: Screen, stencil: Stencil) -> np.ndarray:
    """int32 [height, width]: how often the stencil of every pixel was updated."""
    return stencil.layers + spread(screen, stencil.whole_layers)
