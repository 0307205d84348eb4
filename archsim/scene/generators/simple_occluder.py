"""One triangle above a plane, z up: the Simple scene of [Aila04], whose shadow volume has eight triangles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.generators.shapes import NO_SHADOW, ground, join
from archsim.scene.mesh import Mesh


class Parameters(NamedTuple):
    """Sizes in world units."""

    size: float = 2.0  # from the triangle's middle to its corners
    height: float = 2.0  # above the plane
    plane_half_size: float = 40.0


LOWEST = Parameters(1e-6, 0.0, 1e-6)


def num_triangles(parameters: Parameters) -> int:
    return 3


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """The plane, which casts no shadow, and the triangle; nothing in it is random."""
    angle = np.pi / 2 + np.arange(3) * (2 * np.pi / 3)
    heights = np.full(3, parameters.height)
    corners = np.stack([parameters.size * np.cos(angle), parameters.size * np.sin(angle), heights], axis=1)
    plane = ground(parameters.plane_half_size, 1, np.zeros((2, 2)))
    return join([plane, Mesh(corners, np.array([(0, 1, 2)]))], [NO_SHADOW, 0])
