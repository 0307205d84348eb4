"""Stone steps around a stage with columns and characters on it, z up; a stand-in for the Amphitheater of [Aila04]."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.scene.generators import characters
from archsim.scene.generators.shapes import NO_SHADOW, ground, join, tube_triangles, tubes
from archsim.scene.mesh import Mesh


class Parameters(NamedTuple):
    """Counts, and sizes in world units; a character is about two units tall."""

    actors: int = 10
    columns: int = 10
    column_sides: int = 16
    rows: int = 12  # of steps
    step_sides: int = 48  # along the half circle
    pose: float = 0.0  # of the first actor's animation of nine frames
    stage_radius: float = 9.0
    step_depth: float = 1.2
    step_height: float = 0.7
    column_height: float = 6.0


LOWEST = Parameters(1, 1, 3, 1, 3, 0.0, 1e-6, 1e-6, 1e-6, 1e-6)
COLUMN_RADIUS = 0.05  # of the height


def num_triangles(parameters: Parameters) -> int:
    """Ground, steps, columns, actors."""
    steps = 4 * parameters.rows * parameters.step_sides
    columns = parameters.columns * tube_triangles(2, parameters.column_sides)
    return 2 + steps + columns + characters.num_triangles(parameters.actors)


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """Ground and steps, which cast no shadows, then columns along the straight side, then actors on the stage.

    The columns are one object, as a building that is one model; each actor is one.
    """
    half = parameters.stage_radius + parameters.rows * parameters.step_depth
    floor = ground(1.5 * half, 1, np.zeros((2, 2)))
    columns, actors = _columns(parameters), characters.characters(_stance(random, parameters))
    parts = [floor, _steps(parameters), *columns, *actors]
    colonnade = [0] * len(columns)
    return join(parts, [NO_SHADOW, NO_SHADOW, *colonnade, *range(1, len(actors) + 1)])


def _steps(parameters: Parameters) -> Mesh:
    """Risers and treads around the half circle y > 0, from the stage outwards; they look to the stage and up."""
    angle = np.linspace(0, np.pi, parameters.step_sides + 1)
    row = np.arange(parameters.rows)
    radius = (
        parameters.stage_radius + np.repeat(np.append(row, parameters.rows), 2)[1:] * parameters.step_depth
    )
    radius = np.insert(radius, 0, parameters.stage_radius)[: 2 * parameters.rows + 1]
    height = np.append(0.0, np.repeat(row + 1, 2))[: 2 * parameters.rows + 1] * parameters.step_height
    profile = np.stack(
        [
            radius[:, None] * np.cos(angle),
            radius[:, None] * np.sin(angle),
            np.broadcast_to(height[:, None], (len(radius), len(angle))),
        ],
        axis=-1,
    )
    ring, side = np.meshgrid(np.arange(len(radius) - 1), np.arange(len(angle) - 1), indexing="ij")
    a = ring * len(angle) + side
    b, c, d = a + 1, a + len(angle) + 1, a + len(angle)
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    return Mesh(profile.reshape(-1, 3), triangles)


def column_feet(parameters: Parameters) -> np.ndarray:
    """float64 [columns, 3]: in a row along the straight side, a fifth of their height before it."""
    place = np.linspace(-0.9, 0.9, parameters.columns) * parameters.stage_radius
    before = np.full_like(place, -0.2 * parameters.column_height)
    return np.stack([place, before, np.zeros_like(place)], axis=1)


def actor_places(parameters: Parameters) -> np.ndarray:
    """float64 [actors, 3]: spread over the half disc of the stage."""
    number = parameters.actors
    distance = 0.85 * parameters.stage_radius * np.sqrt((np.arange(number) + 0.5) / number)
    angle = np.pi * ((np.arange(number) * 0.618) % 1.0)
    return np.stack([distance * np.cos(angle), distance * np.sin(angle), np.zeros(number)], axis=1)


def _columns(parameters: Parameters) -> list[Mesh]:
    """Each by itself."""
    height, foot = parameters.column_height, column_feet(parameters)
    points = np.stack([foot, foot + (0.0, 0.0, height)], axis=1)
    radius = np.array([COLUMN_RADIUS * height])
    return [tubes(ends[None], radius, parameters.column_sides) for ends in points]


def _stance(random: np.random.Generator, parameters: Parameters) -> characters.Stance:
    """Actors at their places, turned anyhow, each at a time of its own of the animation."""
    number = parameters.actors
    pose = parameters.pose + random.uniform(0, 9, number)
    return characters.Stance(actor_places(parameters), random.uniform(0, 2 * np.pi, number), pose)
