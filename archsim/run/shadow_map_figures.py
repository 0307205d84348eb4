"""Histograms and images of shadow maps, for their report."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest

import numpy as np

from archsim.run.result import Histogram
from archsim.run.tile_pipeline import DrawnMap, phase_of

LARGEST_IMAGE = 512  # rows and columns of a map as the report shows it


def map_histograms(maps: Sequence[DrawnMap]) -> list[Histogram]:
    """Depth complexity, and what compression leaves of the blocks; over all maps."""
    layers = [sum(each) for each in zip_longest(*(each.drawn.layers.tolist() for each in maps), fillvalue=0)]
    held = np.concatenate([each.held for each in maps])
    return [
        Histogram("Depth complexity: triangles over a texel", "triangles", "texels", np.array(layers)),
        Histogram("Bytes in memory of each block of the finished maps", "bytes", "blocks", np.bincount(held)),
    ]


def depth_images(maps: Sequence[DrawnMap]) -> dict[str, np.ndarray]:
    """Each map, nearest depth 0; NaN where nothing was drawn; large ones thinned out."""
    images = {}
    for each in maps:
        step = -(-max(each.depth.shape) // LARGEST_IMAGE)
        depth = each.depth[::-step, ::step].astype(np.float32) / each.depth.dtype.type((1 << 24) - 1)
        title = f"{phase_of(each.shadow_map)}: depth, y' upwards [0 nearest, 1 farthest]"
        images[title] = np.where(depth < 1, depth, np.nan)
    return images
