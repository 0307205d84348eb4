"""Figure 8 of Johnson, Mark, Burns 2004: image error over the number of shadow-map samples.

The paper's curves are not in its text, nor how it normalised the L2 norm. Ours is the root mean square difference of
the pixels' brightness, 0 ... 1, between a picture and the ray-traced one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from archsim import resources
from archsim.config import load_run
from archsim.run.progress import Progress, silent
from archsim.scene.scene import Scene, load_scene
from archsim.shadow.map_quality import METHODS, Point, quality, stage_of

NUMBER = 8
TITLE = "Image error over the number of shadow-map samples, both lights of the level together"
SIZES = (64, 128, 256, 512, 1024, 2048, 4096)  # texels on a side of conventional maps
NUM_LEVELS = 8  # of adaptive maps, the finest of 4096 texels on a side


def reproduce(progress: Progress = silent, overrides: Iterable[str] = ()) -> list[Point]:
    """The points of all methods, by method and size."""
    path = resources.experiment("johnson2004") / "doom_light0.yaml"
    config = load_run(path, overrides)
    return measure(load_scene(config.scene), SIZES, NUM_LEVELS, progress)


def measure(scene: Scene, sizes: Sequence[int], num_levels: int, progress: Progress) -> list[Point]:
    """The same of any scene."""
    total = len(sizes) * len(METHODS) + num_levels + 1
    points = []
    progress("figure 8", 0, total)
    for point in quality(stage_of(scene), sizes, num_levels):
        points.append(point)
        progress("figure 8", len(points), total)
    return sorted(points)
