"""From pixel and depth to logical cells in one linear step: the constants that the build kernel is given.

With z the eye depth, a sample is P = eye + z (corner + x step_x + y step_y). Divided by z, its light-space position is
linear in x, y and 1/z, and the division by W that follows cancels the 1/z: no inverse of z is ever taken.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.camera import pixel_rays
from archsim.scene.scene import Scene
from archsim.shadow.light_view import LightFace


class LightTransform(NamedTuple):
    """float32 vectors (X, Y, z, W) that add up to a sample's homogeneous logical position over z."""

    step_x: np.ndarray  # [4] one pixel to the right; z = W, so that z / W becomes 1 - nearest / W
    step_y: np.ndarray  # [4] one pixel down
    depth: np.ndarray  # [4] one unit of reciprocal eye depth; its z is W - nearest
    pair: np.ndarray  # [num_pairs, 4] first pixel of each pair relative to its tile, plus the image's origin


def light_transform(scene: Scene, face: LightFace, tile: tuple[int, int]) -> LightTransform:
    """The transform of a light view for tiles of the given width and height."""
    origin, corner, step_x, step_y = pixel_rays(scene.camera, scene.width, scene.height)
    pairs_wide = tile[0] // 2
    pair = np.arange(pairs_wide * tile[1])[:, None]
    offset = corner + pair % pairs_wide * 2 * step_x + pair // pairs_wide * step_y
    return LightTransform(
        _lanes(face, step_x),
        _lanes(face, step_y),
        _lanes(face, origin - face.light, face.nearest),
        _lanes(face, offset),
    )


def _lanes(face: LightFace, world: np.ndarray, nearest: float = 0.0) -> np.ndarray:
    """World vectors [..., 3] as float32 lanes (X, Y, W - nearest, W)."""
    homogeneous = np.asarray(world, np.float64) @ face.to_logical.T
    lanes = np.empty(homogeneous.shape[:-1] + (4,), np.float32)
    lanes[..., [0, 1, 3]] = homogeneous
    lanes[..., 2] = homogeneous[..., 2] - nearest
    return lanes
