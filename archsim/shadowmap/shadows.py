"""Shadows in the image: each visible point looks up its texel in the map that serves it. [Lloyd07] sec. 3.1, step 4"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from archsim.lograster.depth_buffer import FARTHEST
from archsim.shadowmap.error import owner, places
from archsim.shadowmap.fit import ShadowMap, with_one
from archsim.shadowmap.picture import Picture
from archsim.shadowmap.view import View


def shadow_image(
    maps: Sequence[ShadowMap], depths: Sequence[np.ndarray], view: View, picture: Picture
) -> np.ndarray:
    """Bool [rows, columns]: the pixels in shadow, by the nearest texel of the drawn `depths` of each map.

    Surfaces whose visible side is turned away from the light are in shadow, too; what is at a point light is lit.
    """
    dark = turned_away(maps[0].light, view, picture)
    owners = owner(list(maps), picture.points)
    for index, (shadow_map, depth) in enumerate(zip(maps, depths, strict=True)):
        mine = owners == index
        dark[mine] |= behind(shadow_map, depth, picture.points[mine])
    image = np.zeros(picture.seen.shape, dtype=np.bool_)
    image[picture.seen] = dark
    return image


def behind(shadow_map: ShadowMap, depth: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Which points [n, 3] lie behind what their texel of a drawn map, int32 [rows, columns], holds; bool [n]."""
    rows, columns = depth.shape
    here = places(shadow_map, points)
    column = np.clip(np.floor(here.x * columns), 0, columns - 1).astype(np.int64)
    row = np.clip(np.floor(here.y * rows), 0, rows - 1).astype(np.int64)
    image = with_one(points) @ shadow_map.matrix[2:].T
    own = np.clip(image[:, 0] / image[:, 1], 0.0, 1.0) * FARTHEST
    return np.asarray(own > depth[row, column])


def turned_away(light: np.ndarray, view: View, picture: Picture) -> np.ndarray:
    """Bool [n]: which of the pixels seen show the side of their surface that the light cannot reach."""
    to_light = ((light[:3] - light[3] * picture.points) * picture.normals).sum(axis=1)
    to_eye = ((view.eye - picture.points) * picture.normals).sum(axis=1)
    return np.asarray(to_light * to_eye < 0)
