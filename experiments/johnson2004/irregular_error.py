"""What is left of the irregular map's image error in figure 8, and what it hangs on. As Markdown.

Run: python experiments/johnson2004/irregular_error.py [--resolution WIDTH HEIGHT]

The depth offset of the occluders is changed, and the pixels that come out other than ray traced are counted: shadowed
though lit, or lit though shadowed, and how many of these have a neighbour on the other side of a ray-traced edge.
"""

from __future__ import annotations

import argparse

import numpy as np

from archsim import resources
from archsim.config import load_run
from archsim.scene.scene import load_scene
from archsim.shadow import plain
from archsim.shadow.grid import Grid
from archsim.shadow.map_quality import TILE, Stage, stage_of
from archsim.shadow.shading import l2_difference

OFFSETS = (
    0.0,
    2.0**-12,
    2.0**-9,
    2.0**-6,
    2.0**-3,
)  # cells; 0: the rounding error, as figure 8; 2^-6: as runs
GRID = Grid(512, 512, 256, 256, 8, 8)  # of figure 8


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--resolution", nargs=2, type=int, default=[1280, 1024])
    overrides = [f"scene.resolution={parser.parse_args().resolution}"]
    config = load_run(resources.experiment("johnson2004") / "doom_light0.yaml", overrides)
    stage = stage_of(load_scene(config.scene))
    print(
        "| offset, cells | L2 error | shadowed though lit | lit though shadowed | of both, beside an edge |"
    )
    print("|---|---|---|---|---|")
    for offset in OFFSETS:
        show(stage, offset)


def show(stage: Stage, offset: float) -> None:
    """One line: the error of the picture with all lights, pixels of all lights."""
    scene, method = stage.scene, plain.Method(GRID, TILE, offset)
    masks = [plain.shadow_mask(scene, stage.seen, light, method)[0] for light in scene.lights]
    image, truth = (
        np.sum([light * ~shadow for light, shadow in zip(stage.light, shadows, strict=True)], axis=0)
        for shadows in (masks, stage.reference)
    )
    wrong = [mask != shadow for mask, shadow in zip(masks, stage.reference, strict=True)]
    dark = sum(int((each & mask).sum()) for each, mask in zip(wrong, masks, strict=True))
    bright = sum(int(each.sum()) for each in wrong) - dark
    beside = sum(
        int((each & edges(shadow)).sum()) for each, shadow in zip(wrong, stage.reference, strict=True)
    )
    error = l2_difference(image, truth)
    print(f"| {offset:g} | {error:.5f} | {dark:,} | {bright:,} | {beside:,} |", flush=True)


def edges(shadow: np.ndarray) -> np.ndarray:
    """bool like `shadow`: pixels of which one of the eight neighbours is in shadow and they are not, or the reverse."""
    padded = np.pad(shadow, 1, mode="edge")
    height, width = shadow.shape
    found = np.zeros_like(shadow)
    for row in range(3):
        for column in range(3):
            found |= padded[row : row + height, column : column + width] != shadow
    return found


if __name__ == "__main__":
    main()
