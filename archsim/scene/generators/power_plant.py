"""Steel frames full of pipes, with tanks and chimneys between them; z up.

A stand-in for the UNC power plant, of which [Lloyd07] draws 1.7 million triangles: long, thin, dense geometry
in many layers of depth. The default parameters give 1,700,576. Fewer bays and pipes give a section of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.scene.generators.shapes import (
    BOX_TRIANGLES,
    NO_SHADOW,
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

    bays: int = 10  # of the frame along x and along y
    floors: int = 8
    bay_size: float = 6.0
    pipes: int = 3220
    runs: int = 7  # straight runs of a pipe, at right angles
    pipe_sides: int = 12
    bends: int = 3  # points of an elbow
    tanks: int = 40
    tank_slices: int = 48
    chimneys: int = 4
    places: int = 1  # slabs along x, of as many solids each, into whose objects the solids are put
    kinds: int = 1  # objects of a place, to which its solids are dealt in turn
    walkway: float = (
        0.0  # width of a passage that pipes leave free on every floor, through a bay in the middle
    )


LOWEST = Parameters(1, 1, 1.0, 0, 1, 3, 1, 0, 3, 0, 1, 1, 0.0)
HEADROOM = 2.5  # of walkways
MOST_DRAWS = 10_000  # of a pipe's route
TANK_STACKS = 24
CHIMNEY_RINGS = 33
BRACES = 2  # thin boxes across each cell of a floor: gratings
GROUND_CELLS = 32


def num_triangles(parameters: Parameters) -> int:
    """Ground, and all solids."""
    return 2 * GROUND_CELLS**2 + sum(number * size for number, size in _solids(parameters))


def _solids(parameters: Parameters) -> list[tuple[int, int]]:
    """(how many, triangles of each): beams, pipes, tanks, chimneys."""
    lines = parameters.bays + 1
    beams = parameters.floors * (lines * lines + 2 * lines * parameters.bays + BRACES * parameters.bays**2)
    return [
        (beams, BOX_TRIANGLES),
        (parameters.pipes, tube_triangles(_pipe_points(parameters), parameters.pipe_sides)),
        (parameters.tanks, sphere_triangles(parameters.tank_slices, TANK_STACKS)),
        (parameters.chimneys, tube_triangles(CHIMNEY_RINGS, parameters.tank_slices)),
    ]


def _pipe_points(parameters: Parameters) -> int:
    return 2 + (parameters.runs - 1) * parameters.bends


def make(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """The ground, which casts no shadow, then the solids in the order of `_solids`."""
    size = parameters.bays * parameters.bay_size
    flat = np.zeros((GROUND_CELLS + 1, GROUND_CELLS + 1))
    parts = [ground(4.0 * size, GROUND_CELLS, flat), _frame(parameters)]
    if parameters.pipes:
        routes = [_clear_route(random, parameters) for _ in range(parameters.pipes)]
        points, radii = (np.array(part) for part in zip(*routes, strict=True))
        parts.append(tubes(points, radii, parameters.pipe_sides))
    if parameters.tanks:
        parts.append(_tanks(random, parameters))
    if parameters.chimneys:
        parts.append(_chimneys(random, parameters))
    mesh = join(parts, [NO_SHADOW] + [0] * (len(parts) - 1))
    return mesh._replace(objects=_objects(mesh, parameters))


def _objects(mesh: Mesh, parameters: Parameters) -> np.ndarray:
    """int32 [num_triangles]: the object of each triangle by the place and turn of its solid; the ground is of none."""
    solids = np.concatenate([np.full(number, size) for number, size in _solids(parameters)])
    ends = np.cumsum(solids)
    starts = ends - solids
    casting = mesh.triangles[len(mesh.triangles) - ends[-1] :]
    middles = mesh.vertices[casting, 0].mean(axis=1)
    place = np.add.reduceat(middles, starts) / solids

    rank = np.empty(len(solids), np.int64)
    rank[np.argsort(place, kind="stable")] = np.arange(len(solids))
    slab = rank * parameters.places // len(solids)
    number = slab * parameters.kinds + np.arange(len(solids)) % parameters.kinds
    ground = np.full(len(mesh.triangles) - len(casting), NO_SHADOW)
    return np.concatenate([ground, np.repeat(number, solids)]).astype(np.int32)


def _frame(parameters: Parameters) -> Mesh:
    """Columns, beams along x and y, and gratings, floor by floor."""
    bay, half = parameters.bay_size, 0.5 * parameters.bays * parameters.bay_size
    line = np.arange(parameters.bays + 1) * bay - half
    cell = line[:-1]
    level = np.arange(parameters.floors) * bay
    columns = _combinations(line, line, level)
    along_x, along_y = _combinations(cell, line, level + bay), _combinations(line, cell, level + bay)
    lows = [columns - (0.15, 0.15, 0.0), along_x - (0.0, 0.1, 0.3), along_y - (0.1, 0.0, 0.3)]
    highs = [columns + (0.15, 0.15, bay), along_x + (bay, 0.1, 0.0), along_y + (0.1, bay, 0.0)]
    for index in range(BRACES):
        brace = _combinations(cell + bay * (index + 1) / (BRACES + 1), cell, level + bay)
        lows.append(brace - (0.3, 0.0, 0.05))
        highs.append(brace + (0.3, bay, 0.0))
    return boxes(np.concatenate(lows), np.concatenate(highs))


def _combinations(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """All points (x, y, z), z slowest; float [n, 3]."""
    grid = np.meshgrid(z, y, x, indexing="ij")
    return np.stack(grid[::-1], axis=-1).reshape(-1, 3)


def walkway_middle(parameters: Parameters) -> float:
    """x of the walkways, which go along y."""
    return (parameters.bays // 2 + 0.5 - 0.5 * parameters.bays) * parameters.bay_size


def _clear_route(random: np.random.Generator, parameters: Parameters) -> tuple[np.ndarray, float]:
    """The first of the routes drawn that leaves the walkways free."""
    for _ in range(MOST_DRAWS):
        points, radius = _route(random, parameters)
        if not parameters.walkway or _leaves_walkways(points, radius, parameters):
            return points, radius
    raise fail(f"walkways {parameters.walkway:g} wide leave pipes no room in bays of {parameters.bay_size:g}")


def _leaves_walkways(points: np.ndarray, radius: float, parameters: Parameters) -> bool:
    """Whether the boxes around a pipe's pieces meet no walkway."""
    low = np.minimum(points[:-1], points[1:]) - radius
    high = np.maximum(points[:-1], points[1:]) + radius
    middle, half = walkway_middle(parameters), 0.5 * parameters.walkway
    beside = (low[:, 0] > middle + half) | (high[:, 0] < middle - half)
    above_floor = low[:, 2] % parameters.bay_size
    over = (above_floor > HEADROOM) & (above_floor + high[:, 2] - low[:, 2] < parameters.bay_size)
    return bool((beside | over).all())


def _route(random: np.random.Generator, parameters: Parameters) -> tuple[np.ndarray, float]:
    """(points, radius) of a pipe that goes through the frame in straight runs along the axes, with rounded
    elbows.
    """
    size = np.array([parameters.bays, parameters.bays, parameters.floors]) * parameters.bay_size
    radius = 0.04 * 2.0 ** random.uniform(0, 3)
    corners = [random.uniform(0.02, 0.98, 3) * size]
    axis = int(random.integers(3))
    for _ in range(parameters.runs):
        corner = corners[-1].copy()
        step = random.uniform(0.15, 0.4) * size[axis]
        corner[axis] += step if corner[axis] + step < 0.98 * size[axis] else -step
        corners.append(corner)
        axis = (axis + int(random.integers(1, 3))) % 3
    points = [corners[0]]
    for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
        points += _elbow(before, corner, after, 3 * radius, parameters.bends)
    points.append(corners[-1])
    return np.array(points) - (0.5 * size[0], 0.5 * size[1], -0.2), radius


def _elbow(
    before: np.ndarray, corner: np.ndarray, after: np.ndarray, reach: float, num_points: int
) -> list[np.ndarray]:
    """Points of a rounded corner, from `reach` before it to `reach` after it, or as far as the runs allow."""
    inward, outward = before - corner, after - corner
    reach = min(reach, 0.45 * float(np.linalg.norm(inward)), 0.45 * float(np.linalg.norm(outward)))
    start = corner + reach * inward / np.linalg.norm(inward)
    end = corner + reach * outward / np.linalg.norm(outward)
    parts = (np.arange(num_points) + 0.5) / num_points
    return [(1 - t) ** 2 * start + 2 * t * (1 - t) * corner + t**2 * end for t in parts]


def _tanks(random: np.random.Generator, parameters: Parameters) -> Mesh:
    """Round tanks on the ground around the frame, and inside it."""
    reach = parameters.bays * parameters.bay_size
    radii = random.uniform(0.8, 3.0, parameters.tanks)
    centres = random.uniform(-reach, reach, (parameters.tanks, 3))
    centres[:, 2] = radii + 0.2
    return spheres(centres, radii, parameters.tank_slices, TANK_STACKS)


def _chimneys(random: np.random.Generator, parameters: Parameters) -> Mesh:
    reach = parameters.bays * parameters.bay_size
    places = random.uniform(-reach, reach, (parameters.chimneys, 1, 2))
    height = np.linspace(0.0, 2.0 * parameters.floors * parameters.bay_size, CHIMNEY_RINGS)
    points = np.empty((parameters.chimneys, CHIMNEY_RINGS, 3))
    points[:, :, :2], points[:, :, 2] = places, height
    return tubes(points, random.uniform(1.0, 2.5, parameters.chimneys), parameters.tank_slices)
