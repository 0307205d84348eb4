"""The smallest scene with a shadow: a floor and one triangle above it, z up."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.mesh import Mesh


class Parameters(NamedTuple):
    """Sizes in world units."""

    height: float = 0.5  # of the triangle above the floor


LOWEST = Parameters(height=0.0)


def num_triangles(parameters: Parameters) -> int:
    return 3


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """A square floor in z = 0 (triangles 0 and 1) and a triangle at z = height; nothing in it is random."""
    floor = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    floating = [
        (-0.4, -0.3, parameters.height),
        (0.4, -0.3, parameters.height),
        (0.0, 0.4, parameters.height),
    ]
    return Mesh(
        vertices=np.array(floor + floating, dtype=np.float32),
        triangles=np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6)], dtype=np.int32),
    )
