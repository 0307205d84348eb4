"""Rows of robots made of spheres, tubes and boxes on a floor; z up.

A stand-in for the robots of [Lloyd07], which have 95,000 triangles; the default parameters give 94,912.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.generators.shapes import (
    BOX_TRIANGLES,
    boxes,
    ground,
    join,
    sphere_triangles,
    spheres,
    tube_triangles,
    tubes,
)
from archsim.scene.mesh import Mesh


class Parameters(NamedTuple):
    """Counts, and sizes in metres."""

    rows: int = 4  # of robots, one behind the other
    columns: int = 4
    spacing: float = 2.5
    slices: int = 22  # of a joint, and sides of a limb
    stacks: int = 14
    floor_cells: int = 16  # along each side
    floor_size: float = 40.0


LOWEST = Parameters(1, 1, 1.0, 3, 2, 1, 1.0)

# Joints (x, y, z, radius) of a robot 1.9 m tall that looks along +y, and the pairs of them that a limb connects.
JOINTS = (
    (0.0, 0.0, 1.72, 0.16),  # head
    (-0.34, 0.0, 1.42, 0.11),  # shoulders
    (0.34, 0.0, 1.42, 0.11),
    (-0.44, 0.06, 1.12, 0.08),  # elbows
    (0.44, 0.06, 1.12, 0.08),
    (-0.42, 0.28, 0.98, 0.07),  # hands
    (0.42, 0.28, 0.98, 0.07),
    (-0.16, 0.05, 0.48, 0.09),  # knees
    (0.16, 0.05, 0.48, 0.09),
)
LIMBS = ((1, 3), (2, 4), (3, 5), (4, 6))
LEGS = (7, 8)
BOXES = 4  # chest, hip, two feet


def num_triangles(parameters: Parameters) -> int:
    """Floor, and of each robot the joints, limbs, thighs, shins and boxes."""
    joints = len(JOINTS) * sphere_triangles(parameters.slices, parameters.stacks)
    limbs = (len(LIMBS) + 2 * len(LEGS)) * tube_triangles(2, parameters.slices)
    robot = joints + limbs + BOXES * BOX_TRIANGLES
    return 2 * parameters.floor_cells**2 + parameters.rows * parameters.columns * robot


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """The floor, then robot after robot, each turned and in a pose of its own."""
    flat = np.zeros((parameters.floor_cells + 1, parameters.floor_cells + 1))
    parts = [ground(0.5 * parameters.floor_size, parameters.floor_cells, flat)]
    for row in range(parameters.rows):
        for column in range(parameters.columns):
            place = np.array([column, row]) - 0.5 * np.array([parameters.columns, parameters.rows]) + 0.5
            parts.append(_placed(_robot(random, parameters), random, place * parameters.spacing))
    return join(parts)


def _robot(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """A robot on the origin."""
    joints = np.array(JOINTS)
    centres = joints[:, :3].copy()
    centres[3:7] += random.uniform(-0.12, 0.12, (4, 3))
    parts = [spheres(centres, joints[:, 3], parameters.slices, parameters.stacks)]
    limbs = [centres[list(pair)] for pair in LIMBS]
    radii = [0.05] * len(LIMBS)
    for knee in LEGS:
        x = centres[knee, 0]
        limbs += [np.array([(x, 0.0, 0.85), centres[knee]]), np.array([centres[knee], (x, 0.0, 0.08)])]
        radii += [0.07, 0.06]
    parts.append(tubes(np.array(limbs), np.array(radii), parameters.slices))
    lows = np.array([(-0.26, -0.15, 1.0), (-0.24, -0.12, 0.8), (-0.23, -0.1, 0.0), (0.09, -0.1, 0.0)])
    highs = np.array([(0.26, 0.15, 1.5), (0.24, 0.12, 0.95), (-0.09, 0.2, 0.1), (0.23, 0.2, 0.1)])
    parts.append(boxes(lows, highs))
    return join(parts)


def _placed(robot: Mesh, random: np.random.Generator, place: np.ndarray) -> Mesh:
    angle = random.uniform(0, 2 * np.pi)
    turn = np.array([(np.cos(angle), np.sin(angle), 0), (-np.sin(angle), np.cos(angle), 0), (0, 0, 1)])
    return Mesh(robot.vertices @ turn + np.array([*place, 0.0]), robot.triangles)
