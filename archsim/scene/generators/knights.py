"""Knights on a square of ground, z up: the scene of that name of [Aila04], with other characters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.generators import characters
from archsim.scene.generators.shapes import NO_SHADOW, ground, join
from archsim.scene.mesh import Mesh


class Parameters(NamedTuple):
    """Counts, and sizes in world units; a knight is about two units tall."""

    knights: int = 22
    pose: float = 0.0  # the first one's place in its animation of nine frames
    radius: float = 8.0  # of the disc that they stand in
    ground_half_size: float = 20.0


LOWEST = Parameters(1, 0.0, 1e-6, 1e-6)


def num_triangles(parameters: Parameters) -> int:
    return 2 + characters.num_triangles(parameters.knights)


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """The ground, which casts no shadow, and the knights, spread evenly and turned at random."""
    number = parameters.knights
    index = np.arange(number)
    distance = parameters.radius * np.sqrt((index + 0.5) / number)
    angle = index * np.pi * (3 - np.sqrt(5)) + random.uniform(-0.2, 0.2, number)
    place = np.stack([distance * np.cos(angle), distance * np.sin(angle), np.zeros(number)], axis=1)
    pose = parameters.pose + random.uniform(0, 9, number)
    stance = characters.Stance(place, random.uniform(0, 2 * np.pi, number), pose)
    plane = ground(parameters.ground_half_size, 1, np.zeros((2, 2)))
    return join([plane, *characters.characters(stance)], [NO_SHADOW, *range(number)])
