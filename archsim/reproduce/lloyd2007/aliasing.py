"""Figure 7: how large texels are in the image, in numbers and pictures; and the storage that would make them
pixels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.reproduce.lloyd2007.views import load_walk
from archsim.scene.camera import Camera
from archsim.shadowmap.allocation import needed, sizes_of
from archsim.shadowmap.families import FAMILIES, make_maps
from archsim.shadowmap.fit import ShadowMap
from archsim.shadowmap.picture import Aliasing, Picture, aliasing, take_picture
from archsim.shadowmap.view import View, directional_light, make_view, point_light

COMPARED = ("standard", "fp_lispsm", "csm_lispsm", "logpsm")
IMAGE = 512
TEXELS = 512 * 512
RATIOS = (10, 100, 1000, 10_000)
LINE_TEXELS = 5  # between grid lines
GREEN, YELLOW, RED = (np.array(colour) for colour in ((0, 158, 115), (240, 228, 66), (213, 94, 0)))


class Fitted(NamedTuple):
    """A family fitted to the picture with a total number of texels."""

    maps: list[ShadowMap]
    sizes: list[tuple[int, int]]
    errors: Aliasing


def fit_family(family: str, view: View, light: np.ndarray, picture: Picture, texels: int) -> Fitted:
    """A family's maps of so many texels together, and their error in a picture."""
    maps = make_maps(family, view, light)
    sizes = sizes_of(family, maps, view, picture.seen.shape[0], texels)
    return Fitted(maps, sizes, aliasing(maps, sizes, view, picture))


def figure7() -> tuple[Picture, dict[str, Fitted]]:
    """The first frame of the town, 512 x 512 pixels, with 512 x 512 texels in each family."""
    walk = load_walk("town")
    frame = walk.frames[0]
    picture = take_picture(walk.mesh, frame.camera, frame.view, IMAGE, IMAGE)
    return picture, {
        family: fit_family(family, frame.view, frame.light, picture, TEXELS) for family in COMPARED
    }


def error_image(picture: Picture, errors: Aliasing) -> np.ndarray:
    """m as colours, uint8 [rows, columns, 3]: green at 1, yellow at 3, red from 10 on; black where maps meet."""
    level = np.log(np.clip(errors.error, 1, 10)) / np.log(10)
    at_yellow = np.log(3) / np.log(10)
    below, above = np.clip(level / at_yellow, 0, 1), np.clip((level - at_yellow) / (1 - at_yellow), 0, 1)
    colours = GREEN + below[:, None] * (YELLOW - GREEN) + above[:, None] * (RED - YELLOW)
    owners = _spread(picture, errors.owner + 1.0)
    image = _spread(picture, colours)
    image[_changes(owners) & picture.seen] = 0
    return image.astype(np.uint8)


def grid_image(picture: Picture, errors: Aliasing) -> np.ndarray:
    """A line for every fifth texel, uint8 [rows, columns, 3], on surfaces shaded by their slope."""
    lines = np.floor(errors.texel / LINE_TEXELS)
    dark = np.zeros(picture.seen.shape, dtype=bool)
    for axis in range(2):
        dark |= _changes(_spread(picture, lines[:, axis]))
    shade = 200 + 50 * picture.normals @ np.array([0.2, 0.3, 0.9])
    image = _spread(picture, np.repeat(shade[:, None], 3, axis=1))
    image[dark & picture.seen] = (0, 114, 178)
    return np.clip(image, 0, 255).astype(np.uint8)


def _spread(picture: Picture, values: np.ndarray) -> np.ndarray:
    """Values [n, ...] of the pixels seen as an image; white (255) elsewhere."""
    image = np.full(picture.seen.shape + values.shape[1:], 255.0)
    image[picture.seen] = values
    return image


def _changes(image: np.ndarray) -> np.ndarray:
    """Pixels that differ from the one to the right or below."""
    changed = np.zeros(image.shape, dtype=bool)
    changed[:, :-1] |= image[:, :-1] != image[:, 1:]
    changed[:-1] |= image[:-1] != image[1:]
    return changed


def storage() -> dict[str, list[float]]:
    """family -> texels that it needs so that none is larger than a pixel, in images, at each of RATIOS."""
    light = directional_light(np.array([0.01, 0.02, 1.0]))
    found = {}
    for family in FAMILIES:
        sizes = [needed(make_maps(family, view, light), view, IMAGE) for view in map(_view, RATIOS)]
        found[family] = [float(each.prod(axis=1).sum()) / IMAGE**2 for each in sizes]
    return found


def mean_partitions(num_lights: int = 400) -> tuple[float, float]:
    """Logarithmic maps on average, over directions and over places in the view drawn at random."""
    random = np.random.Generator(np.random.PCG64(0))
    view = _view(1000)
    directions = [directional_light(random.normal(size=3)) for _ in range(num_lights)]
    places = [point_light(_inside(random, view)) for _ in range(num_lights)]
    means = [
        np.mean([len(make_maps("logpsm", view, light)) for light in lights])
        for lights in (directions, places)
    ]
    return float(means[0]), float(means[1])


def _inside(random: np.random.Generator, view: View) -> np.ndarray:
    x, y, depth = (
        random.uniform(-0.9, 0.9),
        random.uniform(-0.9, 0.9),
        view.near * view.ratio ** random.uniform(0.1, 0.9),
    )
    return np.asarray(view.eye + np.array([x * view.tan_x, y * view.tan_y, 1.0]) * depth @ view.axes)


def _view(ratio: float) -> View:
    camera = Camera(np.zeros(3), np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), 60.0, 1.0)
    return make_view(camera, 1.0, float(ratio))
