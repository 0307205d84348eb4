"""Streets of houses with gables, windows and chimneys, and trees of many leaves, on rolling ground; z up.

A stand-in for the town of [Lloyd07], which has 58,000 triangles; the default parameters give 58,068:

    ground    2 x 60 x 60 cells                              7,200
    houses    81 x (18 boxes x 12 + gable 6)                17,982
    trees     162 x (trunk 24 + 179 leaves)                 32,886
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.generators.shapes import BOX_TRIANGLES, boxes, ground, join, tube_triangles, tubes
from archsim.scene.mesh import Mesh


class Parameters(NamedTuple):
    """Counts, and sizes in metres."""

    blocks: int = 9  # houses along each side of the town
    block_size: float = 24.0  # from house to house
    windows: int = 16  # of a house
    trees: int = 162
    leaves: int = 179  # of a tree: one triangle each
    ground_cells: int = 60  # along each side
    ground_size: float = 600.0  # side of the ground
    roughness: float = 0.4  # height of the ground's waves


LOWEST = Parameters(1, 4.0, 0, 0, 0, 1, 1.0, 0.0)
GABLE_TRIANGLES = 6
TRUNK_SIDES = 6


def num_triangles(parameters: Parameters) -> int:
    """As in the table above."""
    house = (2 + parameters.windows) * BOX_TRIANGLES + GABLE_TRIANGLES
    tree = tube_triangles(2, TRUNK_SIDES) + parameters.leaves
    return 2 * parameters.ground_cells**2 + parameters.blocks**2 * house + parameters.trees * tree


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """Ground, then the houses row by row, then the trees."""
    line = np.linspace(-0.5, 0.5, parameters.ground_cells + 1) * parameters.ground_size
    heights = _height(*np.meshgrid(line, line), parameters)
    parts = [ground(0.5 * parameters.ground_size, parameters.ground_cells, heights)]
    places = (np.arange(parameters.blocks) - 0.5 * (parameters.blocks - 1)) * parameters.block_size
    for y in places:
        for x in places:
            parts += _house(random, x, y, parameters)
    for _ in range(parameters.trees):
        parts += _tree(random, parameters)
    return join(parts)


def _height(x: np.ndarray, y: np.ndarray, parameters: Parameters) -> np.ndarray:
    return np.asarray(parameters.roughness * np.sin(x / 31.0) * np.cos(y / 43.0))


def _house(random: np.random.Generator, x: float, y: float, parameters: Parameters) -> list[Mesh]:
    """Walls, a gable roof along x, a chimney, windows that stand out a little on all four walls."""
    half = np.array([random.uniform(0.22, 0.34), random.uniform(0.18, 0.28)]) * parameters.block_size
    eaves = random.uniform(4.0, 9.0)
    base = float(_height(np.array(x), np.array(y), parameters)) - 0.5
    low, high = np.array([x - half[0], y - half[1], base]), np.array([x + half[0], y + half[1], base + eaves])
    ridge = high[2] + random.uniform(1.5, 3.0)
    chimney = np.array([x + 0.5 * half[0], y + 0.3 * half[1], high[2]])
    lows, highs = [low, chimney], [high, chimney + (0.8, 0.8, ridge + 0.8 - high[2])]
    for index in range(parameters.windows):
        axis = index % 2
        side = 1 if index % 4 < 2 else -1
        centre = np.array([x, y, base + random.uniform(1.5, eaves - 1.0)])
        centre[axis] += side * half[axis]
        centre[1 - axis] += random.uniform(-0.8, 0.8) * half[1 - axis]
        size = np.array([0.5, 0.5, 0.7])
        size[axis] = 0.1
        lows.append(centre - size)
        highs.append(centre + size)
    return [boxes(np.array(lows), np.array(highs)), _gable(low, high, ridge)]


def _gable(low: np.ndarray, high: np.ndarray, ridge: float) -> Mesh:
    """Two slopes with eaves, and the two triangles below them."""
    x0, x1, y0, y1, y = low[0] - 0.4, high[0] + 0.4, low[1] - 0.4, high[1] + 0.4, 0.5 * (low[1] + high[1])
    z = high[2]
    vertices = np.array([(x0, y0, z), (x1, y0, z), (x1, y, ridge), (x0, y, ridge), (x1, y1, z), (x0, y1, z)])
    triangles = [(0, 1, 2), (0, 2, 3), (3, 2, 4), (3, 4, 5), (0, 3, 5), (1, 4, 2)]
    return Mesh(vertices, np.array(triangles))


def _tree(random: np.random.Generator, parameters: Parameters) -> list[Mesh]:
    """A trunk, and leaves that fill a ball; it stands between the houses."""
    cells = parameters.blocks + 1
    cell = random.integers(0, cells, 2) - 0.5 * cells
    x, y = (
        cell + random.uniform(-0.12, 0.12, 2) + 0.5 * (parameters.blocks % 2 == 0)
    ) * parameters.block_size
    base = float(_height(np.array(x), np.array(y), parameters)) - 0.3
    height, crown = random.uniform(2.5, 4.5), random.uniform(1.5, 3.0)
    trunk = tubes(np.array([[(x, y, base), (x, y, base + height)]]), np.array([0.2]), TRUNK_SIDES)

    directions = random.normal(size=(parameters.leaves, 3))
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    outward = (
        directions / np.maximum(lengths, 1e-9) * random.uniform(0.3, 1.0, (parameters.leaves, 1)) * crown
    )
    centres = np.array([x, y, base + height + 0.7 * crown]) + outward
    corners = centres[:, None] + 0.28 * random.normal(size=(parameters.leaves, 3, 3))
    return [trunk, Mesh(corners.reshape(-1, 3), np.arange(3 * parameters.leaves).reshape(-1, 3))]
