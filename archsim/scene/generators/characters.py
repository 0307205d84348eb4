"""Animated characters out of packaged meshes, standing in z = 0, z up."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim import resources
from archsim.scene.mesh import Mesh

NAMES = ("glest_swordman", "glest_guard")  # closed, about two units tall, y up in their files
TRIANGLES = (562, 532)


class Stance(NamedTuple):
    """How characters stand."""

    place: np.ndarray  # float64 [n, 3]
    turn: np.ndarray  # float64 [n] radians around z
    pose: np.ndarray  # float64 [n] place in the animation; whole numbers are its frames, and it repeats


def num_triangles(number: int) -> int:
    """Of the first `number` characters; the names take turns."""
    return sum(TRIANGLES[index % len(NAMES)] for index in range(number))


def characters(stance: Stance) -> list[Mesh]:
    """One mesh for each."""
    animations = [_animation(name) for name in NAMES]
    return [
        _posed(*animations[index % len(NAMES)], place, turn, pose)
        for index, (place, turn, pose) in enumerate(zip(*stance, strict=True))
    ]


def _animation(name: str) -> tuple[np.ndarray, np.ndarray]:
    """(vertices of each frame float64 [frames, n, 3] with z up, triangles [m, 3])."""
    with np.load(resources.mesh(name), allow_pickle=False) as arrays:
        x, y, z = np.moveaxis(arrays["frames"].astype(np.float64), -1, 0)
        return np.stack([x, -z, y], axis=-1), arrays["f"].astype(np.int64)


def _posed(frames: np.ndarray, triangles: np.ndarray, place: np.ndarray, turn: float, pose: float) -> Mesh:
    """A character between two frames of its animation."""
    before = int(np.floor(pose))
    share = pose - before
    vertices = (1 - share) * frames[before % len(frames)] + share * frames[(before + 1) % len(frames)]
    cosine, sine = np.cos(turn), np.sin(turn)
    turned = vertices @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return Mesh(turned + place, triangles)
