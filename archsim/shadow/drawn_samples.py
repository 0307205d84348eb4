"""Samples of a drawn light view: patches of pixels, each seen by the light as a turned rectangle of one density.

The kernel divides a pixel's homogeneous position by W. Here W is the pixel's reciprocal depth alone, the same
for all pixels of a patch, so its inverse is the patch's scale; a tile's origin is chosen so that the tile lands where
it should.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.shadow.grid import Grid, head_of_logical
from archsim.shadow.light_view import MARGIN_CELLS
from archsim.shadow.pixel_tiles import PixelTiles, cut
from archsim.shadow.transform import LightTransform

_LEAST_COSINE = 2.0**-6  # to the light
_STEPS = 24  # bisections of the patches' size
_SMALLEST, _LARGEST = (
    2.0**-7,
    2.0**7,
)  # size of a patch of mean density, as part of its share of the light view


class DrawnSamples(NamedTuple):
    """Pixel tiles and what takes them to logical cells."""

    tiles: PixelTiles
    transform: LightTransform
    image: np.ndarray  # float32 [height, width] reciprocal depth
    patch_of_pixel: np.ndarray  # int32 [height, width]


class _Patches(NamedTuple):
    """Where the light sees the patches, in logical cells; [rows, columns] of patches, last axis x and y."""

    origin: np.ndarray  # float64 [rows, columns, 2] of the first pixel
    scale: np.ndarray  # float64 [rows, columns]
    steps: (
        np.ndarray
    )  # float64 [2, 2] cells (x, y) to the pixel on the right, to the one below, in a patch of scale 1


def draw_samples(
    statistics: Any, grid: Grid, tile: tuple[int, int], rng: np.random.Generator
) -> DrawnSamples:
    """Patches of such a size that the lists get about the wanted length. `statistics`: drawn.Statistics."""
    (width, height), patch = statistics.resolution, statistics.patch
    counts = (-(-height // patch[1]), -(-width // patch[0]))
    turn = rng.uniform(0, 2 * np.pi)
    density = _densities(counts, rng)
    wanted = width * height / statistics.list_length

    low, high = np.log(_SMALLEST), np.log(_LARGEST)
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        patches = _place(statistics, grid, density, turn, float(np.exp(middle)))
        found = _num_lists(grid, _pixel_cells(patches, statistics))
        low, high = (middle, high) if found < wanted else (low, middle)
    return _as_tiles(_place(statistics, grid, density, turn, float(np.exp(high))), statistics, tile)


def _densities(counts: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Samples a cell of patches that are turned at random: cosine to the eye over cosine to the light.

    Of the patches that the eye sees, pixel by pixel, the first cosine is more often large, the second is uniform.
    """
    to_eye, to_light = np.sqrt(rng.random(counts)), rng.random(counts)
    return to_eye / np.maximum(to_light, _LEAST_COSINE)


def _place(statistics: Any, grid: Grid, density: np.ndarray, turn: float, size: float) -> _Patches:
    """Patches in an ellipse, laid out as in the eye view, moved inside the stencil's box and stretched to fill it."""
    shares, patch = np.array(density.shape[::-1]), np.array(statistics.patch)
    extent = np.array(statistics.stencil, float)
    share = extent / shares
    right, down = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    steps = np.stack([right / patch[0], down / patch[1]]) * share
    reach = np.abs(steps * (patch - 1)[:, None]).sum(axis=0)  # width and height of a patch of scale 1
    scale = np.minimum(size / np.sqrt(density), (extent / reach).min())
    spread = scale[..., None] * reach
    row, column = np.mgrid[0 : density.shape[0], 0 : density.shape[1]]
    x, y = 2 * (column + 0.5) / shares[0] - 1, 2 * (row + 0.5) / shares[1] - 1
    in_disc = np.stack([x * np.sqrt(1 - 0.5 * y * y), y * np.sqrt(1 - 0.5 * x * x)], axis=-1)
    middle = np.clip(0.5 * (in_disc + 1) * extent, 0.5 * spread, extent - 0.5 * spread)

    low, high = ((middle + side * 0.5 * spread) for side in (-1, 1))
    low, high = low.min(axis=(0, 1)), high.max(axis=(0, 1))
    stretch = (extent - 2 * MARGIN_CELLS) / np.maximum(high - low, 1e-9)
    corner = np.array([grid.logical_width, grid.logical_height]) - np.array(statistics.stencil)
    first = middle - 0.5 * scale[..., None] * ((patch - 1) @ steps)
    origin = (first - low) * stretch + corner // 2 + MARGIN_CELLS
    return _Patches(origin, scale, steps * stretch)


def _pixel_cells(patches: _Patches, statistics: Any) -> np.ndarray:
    """Logical column and row of each pixel: int64 [height, width, 2]."""
    (width, height), patch = statistics.resolution, statistics.patch
    y, x = np.mgrid[0:height, 0:width]
    row, column = y // patch[1], x // patch[0]
    within = np.stack([x % patch[0], y % patch[1]], axis=-1) @ patches.steps
    position = patches.origin[row, column] + patches.scale[row, column, None] * within
    return np.floor(position).astype(np.int64)


@njit
def _num_lists(grid, cells):
    """Physical cells in which some pixel has its sample."""
    used = np.zeros(grid.physical_width * grid.physical_height, np.bool_)
    for y in range(cells.shape[0]):
        for x in range(cells.shape[1]):
            used[head_of_logical(grid, cells[y, x, 0], cells[y, x, 1])] = True
    return used.sum()


def _as_tiles(patches: _Patches, statistics: Any, tile: tuple[int, int]) -> DrawnSamples:
    (width, height), patch = statistics.resolution, np.array(statistics.patch)
    y, x = np.mgrid[0:height, 0:width]
    row, column = y // patch[1], x // patch[0]
    image = (1.0 / patches.scale[row, column]).astype(np.float32)
    cut_tiles = cut(image, np.ones((height, width), np.bool_), tile)

    first = cut_tiles.origins.astype(np.int64)  # pixel, x and y
    own = first // patch
    scale = patches.scale[own[:, 1], own[:, 0], None]
    origins = patches.origin[own[:, 1], own[:, 0]] / scale @ np.linalg.inv(patches.steps) + first % patch

    step_x, step_y = (np.array([*step, 0, 0], np.float32) for step in patches.steps)
    pairs_wide = tile[0] // 2
    pair = np.arange(pairs_wide * tile[1])[:, None]
    offsets = pair % pairs_wide * 2 * step_x + pair // pairs_wide * step_y
    transform = LightTransform(step_x, step_y, np.array([0, 0, 0, 1], np.float32), offsets.astype(np.float32))
    tiles = cut_tiles._replace(origins=origins.astype(np.float32))
    return DrawnSamples(tiles, transform, image, (row * patches.scale.shape[1] + column).astype(np.int32))
