"""A triangle with its light in a room, z up: the Simple scene of [Aila04].

Places and sizes are those of the program it was taken from, `shadowvol.c` of McReynolds (SGI), among the examples of
GLUT 3.7. There y is up and the room's middle is 420 units before the eye.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.generators.shapes import (
    NO_SHADOW,
    join,
    sphere_triangles,
    spheres,
    tube_triangles,
    tubes,
)
from archsim.scene.mesh import Mesh


class Parameters(NamedTuple):
    """How round the solids are."""

    slices: int = 20


LOWEST = Parameters(3)
HALF_SIZE = 100.0  # of the room, whose front is open
TRIANGLE = ((30.0, -70.0, 30.0), (60.0, -80.0, 20.0), (40.0, -20.0, 40.0))
SPHERE, SPHERE_RADIUS = (60.0, -60.0, -50.0), 20.0
CONE, CONE_RADIUS, CONE_HEIGHT = (-40.0, -20.0, -40.0), 20.0, 60.0
TIP = 1e-3  # of the cone's radius: how far its tip is from a point
WALLS = 5


def num_triangles(parameters: Parameters) -> int:
    """Walls, sphere, cone, triangle."""
    slices = parameters.slices
    return 2 * WALLS + sphere_triangles(slices, slices) + tube_triangles(2, slices) + 1


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """The walls, sphere and cone, which cast no shadows, and the triangle; nothing in it is random."""
    slices = parameters.slices
    sphere = spheres(np.array([SPHERE]), np.array([SPHERE_RADIUS]), slices, slices)
    triangle = Mesh(np.array(TRIANGLE), np.array([(0, 1, 2)]))
    return join([_room(), sphere, _cone(slices), triangle], [NO_SHADOW, NO_SHADOW, NO_SHADOW, 0])


def _room() -> Mesh:
    """Floor, ceiling, left, right and back wall."""
    corners = np.array([[(index >> axis & 1) * 2 - 1 for axis in range(3)] for index in range(8)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 2, 6, 4), (1, 5, 7, 3), (2, 3, 7, 6)]
    triangles = [half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))]
    return Mesh(HALF_SIZE * corners, np.array(triangles))


def _cone(slices: int) -> Mesh:
    """A tube that is narrowed to its tip."""
    foot = np.array(CONE)
    tube = tubes(np.array([[foot, foot + (0.0, 0.0, CONE_HEIGHT)]]), np.array([CONE_RADIUS]), slices)
    width = np.where(tube.vertices[:, 2] > foot[2] + 0.5 * CONE_HEIGHT, TIP, 1.0)
    across = (tube.vertices - foot) * np.stack([width, width, np.ones_like(width)], axis=1)
    return Mesh(foot + across, tube.triangles)
