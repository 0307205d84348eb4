"""A torus knot and spheres in a closed room, z up: "a knot-like shape and several spheres" of [Johnson04].

The default parameters give the 16,372 triangles that the paper prints:

    knot      2 x 295 segments x 20 sides            11,800
    spheres   6 x 2 x 20 slices x (20 - 1) stacks     4,560
    room      6 walls x 2                                12

The room is a cube around the origin, so a camera inside it sees geometry in every pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.generators.shapes import closed_grid, join, unit, unit_sphere
from archsim.scene.mesh import Mesh


class Parameters(NamedTuple):
    """Counts, and sizes in world units."""

    turns_around_axis: int = 2  # p of the (p, q) torus knot
    turns_around_core: int = 3  # q; p and q without a common divisor give one closed curve
    knot_radius: float = 2.0  # of the torus that the knot winds around
    winding_radius: float = 0.8  # of the winding around that torus' core
    tube_radius: float = 0.35
    tube_segments: int = 295
    tube_sides: int = 20
    num_spheres: int = 6
    sphere_radius: float = 0.6  # mean; each radius is drawn within a third of it
    sphere_slices: int = 20
    sphere_stacks: int = 20
    room_half_size: float = 6.0


LOWEST = Parameters(1, 1, 1e-6, 1e-6, 1e-6, 3, 3, 0, 1e-6, 3, 2, 1e-6)


def num_triangles(parameters: Parameters) -> int:
    """As in the table above."""
    knot = 2 * parameters.tube_segments * parameters.tube_sides
    sphere = 2 * parameters.sphere_slices * (parameters.sphere_stacks - 1)
    return knot + parameters.num_spheres * sphere + 12


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """Knot first, then the spheres in order, then the room."""
    parts = [_knot(parameters)]
    for index in range(parameters.num_spheres):
        parts.append(_placed_sphere(random, parameters, index))
    parts.append(_room(parameters.room_half_size))

    return join(parts)


def _knot(parameters: Parameters) -> Mesh:
    """A tube along the torus knot, its rings perpendicular to the curve; parallel quads cut in two."""
    angle = np.arange(parameters.tube_segments) * (2 * np.pi / parameters.tube_segments)
    centre = _knot_curve(angle, parameters)
    tangent = unit(_knot_curve(angle + 1e-4, parameters) - _knot_curve(angle - 1e-4, parameters))
    core_angle = parameters.turns_around_axis * angle
    core = parameters.knot_radius * np.stack([np.cos(core_angle), np.sin(core_angle), 0 * angle], axis=1)
    outward = centre - core  # never along the tangent: it turns around the core
    side = unit(np.cross(tangent, outward))
    normal = np.cross(side, tangent)

    around = np.arange(parameters.tube_sides) * (2 * np.pi / parameters.tube_sides)
    ring = np.cos(around)[None, :, None] * normal[:, None] + np.sin(around)[None, :, None] * side[:, None]
    vertices = centre[:, None] + parameters.tube_radius * ring
    return Mesh(vertices.reshape(-1, 3), closed_grid(parameters.tube_segments, parameters.tube_sides))


def _knot_curve(angle: np.ndarray, parameters: Parameters) -> np.ndarray:
    """Points [n, 3] of the torus knot at curve parameter `angle` [n] in radians."""
    winding = parameters.turns_around_core * angle
    distance = parameters.knot_radius + parameters.winding_radius * np.cos(winding)
    core_angle = parameters.turns_around_axis * angle
    height = parameters.winding_radius * np.sin(winding)
    return np.stack([distance * np.cos(core_angle), distance * np.sin(core_angle), height], axis=1)


def _placed_sphere(random: np.random.Generator, parameters: Parameters, index: int) -> Mesh:
    """Sphere `index`, in its own sector around the knot, at a drawn height and of a drawn radius."""
    radius = parameters.sphere_radius * random.uniform(2 / 3, 4 / 3)
    azimuth = 2 * np.pi * (index + random.uniform(0.3, 0.7)) / parameters.num_spheres
    distance = parameters.knot_radius + parameters.winding_radius + parameters.tube_radius + 1.5 * radius
    height = random.uniform(-1, 1) * parameters.knot_radius
    centre = np.array([distance * np.cos(azimuth), distance * np.sin(azimuth), height])

    sphere = unit_sphere(parameters.sphere_slices, parameters.sphere_stacks)
    return Mesh(centre + radius * sphere.vertices, sphere.triangles)


def _room(half_size: float) -> Mesh:
    """A closed cube around the origin; vertex i has bit 0, 1, 2 of i as its x, y, z side."""
    vertices = [[half_size if index >> axis & 1 else -half_size for axis in range(3)] for index in range(8)]
    walls = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [corners for a, b, c, d in walls for corners in ((a, b, c), (a, c, d))]
    return Mesh(np.array(vertices), np.array(triangles))
