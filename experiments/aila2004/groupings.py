"""What the power plant's DB and H columns make of other objects: `python groupings.py [FRAMES [WIDTH HEIGHT]]`.

Table 1 does not print what one object of the power plant is. Prints a Markdown table for one frame (or FRAMES) at
640 x 512 with the same solids put into objects in several ways; the brute-force column is the same for all.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from archsim.config import load_walkthrough
from archsim.run.frames import Frame, draw_frame
from archsim.run.shadow_volumes import method_of
from archsim.run.walkthrough import resources_of, scenes
from archsim.scene.mesh import Mesh
from archsim.shadow_volumes.casters import Grouping, connected_parts, welded
from archsim.shadow_volumes.comparison import BRUTE_FORCE, DEPTH_BOUNDS, HIERARCHICAL

HERE = Path(__file__).resolve().parent
WAYS = ("parts", "pairs of parts", "cells of the frame")
CELL = 6.0  # bay_size of the section
NO_SHADOW = -1


def main() -> None:
    numbers = [int(word) for word in sys.argv[1:]] or [1]
    width, height = numbers[1:] or (640, 512)
    print("| objects | volumes | BF : DB pixels | BF : H pixels | BF : DB bytes | BF : H bytes |")
    print("|---|---|---|---|---|---|")
    for way in WAYS:
        print(_line(way, drawn(way, numbers[0], width, height)), flush=True)


def drawn(way: str, num_frames: int, width: int, height: int) -> list[Frame]:
    """Frames of the walkthrough with other objects."""
    overrides = [f"frames={num_frames}", f"scene.resolution=[{width},{height}]"]
    config = load_walkthrough(HERE / "powerplant.yaml", overrides)
    method = method_of(config.shadow_volumes, resources_of(config.shadow_volumes))
    method = method._replace(extrusion=method.extrusion._replace(grouping=Grouping.OBJECTS))
    frames = []
    for scene in scenes(config):
        grouped = scene._replace(mesh=scene.mesh._replace(objects=grouping(scene.mesh, way)))
        frames.append(draw_frame(grouped, np.asarray(scene.lights[0].position, np.float64), method))
    return frames


def grouping(mesh: Mesh, way: str) -> np.ndarray:
    """int32 [num_triangles]: objects made of connected parts, in the order of the mesh."""
    positions, triangles = welded(mesh)
    assert mesh.objects is not None
    casting = mesh.objects >= 0
    own = triangles[casting]
    roots = connected_parts(own, np.zeros(len(own), np.int64), len(positions))
    _, first, part = np.unique(roots, return_index=True, return_inverse=True)
    number = np.argsort(np.argsort(first))[part]
    if way == "pairs of parts":
        number //= 2
    elif way == "cells of the frame":
        middles = positions[own].mean(axis=1)
        sums = np.stack([np.bincount(number, weights=column) for column in middles.T], axis=1)
        place = np.floor(sums / np.bincount(number)[:, None] / CELL)
        number = np.unique(place, axis=0, return_inverse=True)[1].ravel()[number]
    objects = np.full(len(mesh.triangles), NO_SHADOW, np.int32)
    objects[casting] = number
    return objects


def _line(way: str, frames: list[Frame]) -> str:
    ratios = []
    for what in ("processed", "total"):
        brute, bounded, hierarchical = (
            sum(getattr(frame.traffic[variant], what) for frame in frames)
            for variant in (BRUTE_FORCE, DEPTH_BOUNDS, HIERARCHICAL)
        )
        ratios += [brute / max(bounded, 1), brute / max(hierarchical, 1)]
    return f"| {way} | {frames[0].volumes} | {' | '.join(f'{ratio:.2f}' for ratio in ratios)} |"


if __name__ == "__main__":
    main()
