"""What the screen shows, tile by tile: the depths that shadow volumes are compared with.

Depth is kept as closeness, 1 / z: linear over a triangle in the image, 0 at infinity.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.shadow_volumes.polygon import GUARD, Frustum

NEARER = (
    1 + 2.0**-20
)  # what a pixel shows counts as this much closer: a surface is not inside its own light cap


class Screen(NamedTuple):
    """The z-buffer and its coarse level."""

    closest: (
        np.ndarray
    )  # float64 [height, width] closeness up to which volumes are behind the pixel; 0 where it is empty
    low: np.ndarray  # float64 [num_tiles] least of it in the tile: zmax
    high: np.ndarray  # float64 [num_tiles] greatest: zmin
    width: int
    height: int
    tile: int  # pixels along a side
    columns: int  # tiles in a row
    rows: int
    frustum: (
        Frustum  # volumes are cut off far beyond the screen's sides, and half way to the view's near plane
    )


def screen(reciprocal_depth: np.ndarray, near: float, tile: int) -> Screen:
    """The screen of an eye view, float32 [height, width] 1 / z or NaN."""
    closest = np.nan_to_num(reciprocal_depth.astype(np.float64)) * NEARER
    height, width = closest.shape
    rows, columns = -(-height // tile), -(-width // tile)
    low = tiled(closest, tile, np.inf).min(axis=1)
    high = tiled(closest, tile, -np.inf).max(axis=1)
    frustum = Frustum(0.5 * near, -GUARD, GUARD, -GUARD, GUARD)
    return Screen(closest, low, high, width, height, tile, columns, rows, frustum)


def tiled(image: np.ndarray, tile: int, outside: float) -> np.ndarray:
    """[num_tiles, tile * tile]: the pixels of each tile, `outside` for those beyond the image."""
    height, width = image.shape
    rows, columns = -(-height // tile), -(-width // tile)
    padded = np.full((rows * tile, columns * tile), outside, image.dtype)
    padded[:height, :width] = image
    blocks = padded.reshape(rows, tile, columns, tile).swapaxes(1, 2)
    return blocks.reshape(rows * columns, tile * tile)


def spread(screen: Screen, tiles: np.ndarray) -> np.ndarray:
    """Values [num_tiles] of tiles at each of their pixels, [height, width]."""
    by_place = tiles.reshape(screen.rows, screen.columns)
    everywhere = by_place.repeat(screen.tile, axis=0).repeat(screen.tile, axis=1)
    return np.asarray(everywhere[: screen.height, : screen.width])
