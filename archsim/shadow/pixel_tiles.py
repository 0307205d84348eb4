"""The eye view cut into tiles of pixels: tile by tile, row by row, pixels in pairs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class PixelTiles(NamedTuple):
    """T tiles of P pixel pairs. Pixels outside of the image, or without a sample in this view, have depth NaN."""

    reciprocal_depth: np.ndarray  # float32 [T, P, 2]
    origins: np.ndarray  # float32 [T, 2] x, y of each tile's first pixel
    pixel: np.ndarray  # int32 [T * P * 2] row * width + column, -1 outside of the image
    tile: tuple[int, int]  # width and height in pixels
    num_columns: int  # tiles side by side

    @property
    def num_pairs(self) -> int:
        return self.reciprocal_depth.shape[1]


def cut(reciprocal_depth: np.ndarray, taken: np.ndarray, tile: tuple[int, int]) -> PixelTiles:
    """Tiles, row by row, of an image [height, width]; pixels that are not `taken` have no sample."""
    height, width = reciprocal_depth.shape
    image = np.where(taken, reciprocal_depth, np.float32(np.nan))
    pixel = np.arange(height * width, dtype=np.int32).reshape(height, width)
    num_rows, num_columns = -(-height // tile[1]), -(-width // tile[0])
    y, x = np.mgrid[0:num_rows, 0:num_columns]
    origins = np.stack([x * tile[0], y * tile[1]], axis=-1).reshape(-1, 2).astype(np.float32)
    depth = _tiled(image, tile, np.float32(np.nan)).reshape(len(origins), -1, 2)
    return PixelTiles(depth, origins, _tiled(pixel, tile, np.int32(-1)).ravel(), tile, num_columns)


def image_order(tiles: PixelTiles) -> np.ndarray:
    """int32 [T * P * 2] place of each pixel, given in tile order, in the image row by row, padding included."""
    (width, height), per_tile = tiles.tile, tiles.num_pairs * 2
    tile, within = np.divmod(np.arange(tiles.reciprocal_depth.size), per_tile)
    row = tile // tiles.num_columns * height + within // width
    column = tile % tiles.num_columns * width + within % width
    return (row * (tiles.num_columns * width) + column).astype(np.int32)


def untile(tiles: PixelTiles, values: np.ndarray, height: int, width: int) -> np.ndarray:
    """An image [height, width] of per-pixel values given in tile order."""
    image = np.zeros(height * width, values.dtype)
    inside = tiles.pixel >= 0
    image[tiles.pixel[inside]] = values[inside]
    return image.reshape(height, width)


def populated_tiles(tiles: PixelTiles) -> np.ndarray:
    """int64 indices of the tiles that hold a sample."""
    return np.flatnonzero(~np.isnan(tiles.reciprocal_depth).all(axis=(1, 2)))


def _tiled(image: np.ndarray, tile: tuple[int, int], outside: np.generic) -> np.ndarray:
    """The image in tile order, padded with `outside` to whole tiles: [tiles, pixels of a tile]."""
    height, width = image.shape
    pad_height, pad_width = -height % tile[1], -width % tile[0]
    padded = np.pad(image, ((0, pad_height), (0, pad_width)), constant_values=outside)
    rows, columns = padded.shape
    blocks = padded.reshape(rows // tile[1], tile[1], columns // tile[0], tile[0])
    return blocks.transpose(0, 2, 1, 3).reshape(-1, tile[0] * tile[1])
