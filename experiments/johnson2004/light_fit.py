"""What a light asks of an irregular shadow map, estimated from few pixels: the columns of Table 1.

A view is scored at a fraction of the resolution. Lists are made on grids reduced by the same factor, which leaves
their lengths alone; samples stand for as many as were left out; triangles are rasterized to the full logical grid,
since small ones would cover too many coarse cells.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from archsim.raster.conservative import rasterize
from archsim.raster.eye_view import EyeView
from archsim.scene.scene import Light, LightView, Scene
from archsim.shadow.grid import Grid
from archsim.shadow.izb import in_shadow
from archsim.shadow.light_view import sample_points
from archsim.shadow.plain import Method, plan_faces, run_face

LOGICAL, PHYSICAL, TILE = 1024, 512, 8  # cells of the paper's grids
NUM_ROLLS = 24
COLUMNS = (
    "list length",
    "stencil width",
    "stencil height",
    "grid fragments pre",
    "grid fragments post",
    "framebuffer fragments pre",
    "framebuffer fragments post",
)

Frame = tuple[np.ndarray, np.ndarray, np.ndarray]  # side, up, forward


class Measured(NamedTuple):
    """Estimates at full resolution."""

    columns: np.ndarray  # float64 [len(COLUMNS)], fragments in millions
    shadowed: float  # share of the pixels


def printed_columns(row: dict) -> np.ndarray:
    """The same columns of a row of `printed.yaml`."""
    grid, frame = row["grid_fragments_M"], row["framebuffer_fragments_M"]
    values = [row["list_length"], *row["stencil"], grid["pre"], grid["post"], frame["pre_z"], frame["post_z"]]
    return np.array(values, float)


def fitted_light(scene: Scene, seen: EyeView, position: np.ndarray, stencil: list[int]) -> Light:
    """The light at a position, its view turned and narrowed so that the stencil gets about the given extent."""
    points = sample_points(scene, seen)
    step = max(1, scene.width // 80)
    directions = unit((points - position)[::step, ::step].reshape(-1, 3))
    wanted = stencil[0] / stencil[1]
    frames = [centred_frame(directions, roll) for roll in np.linspace(0, math.pi, NUM_ROLLS, endpoint=False)]
    side, up, forward = min(frames, key=lambda frame: abs(math.log(aspect_of(directions, frame) / wanted)))

    all_directions = unit((points - position).reshape(-1, 3))
    across, along = extent(all_directions, (side, up, forward))
    half = math.sqrt(across * along / (stencil[0] * stencil[1])) * LOGICAL / 2
    fovy = 2 * math.degrees(math.atan(max(half, 0.51 * max(across, along))))
    view = LightView(rounded(position + forward), rounded(up), round(min(fovy, 170.0), 3))
    return Light(position, view)


def measure(scene: Scene, seen: EyeView, light: Light, scale: int) -> Measured | None:
    """Table 1's columns of a light view at 1 / scale of the resolution; None if one view does not hold all samples."""
    tile = max(1, TILE // scale)
    grid = Grid(*[LOGICAL // scale] * 2, *[PHYSICAL // scale] * 2, tile, tile)
    plans = plan_faces(scene, seen, light, Method(grid, (8, 8), 1 / 64 / scale))
    if len(plans) != 1:
        return None
    outcome = run_face(plans[0], grid)
    found = outcome.workload
    setup = plans[0].occluders.setup
    setup = setup._replace(edges=setup.edges * (1 / scale, 1 / scale, 1.0), bounds=setup.bounds * scale)
    stencil = np.kron(outcome.lists.stencil, np.ones((scale, scale), np.bool_))
    fragments = rasterize(setup, stencil, (TILE, TILE), 2.0**-10)
    millions = scale * scale / 1e6
    columns = [
        found.list_length,
        found.stencil_width * scale,
        found.stencil_height * scale,
        fragments.num_before_stencil / 1e6,
        len(fragments.i) / 1e6,
        found.framebuffer_fragments_pre_z * millions,
        found.framebuffer_fragments_post_z * millions,
    ]
    return Measured(np.array(columns), float(in_shadow(outcome.z_test, outcome.samples).mean()))


def misfit(columns: np.ndarray, printed: np.ndarray) -> float:
    """Sum of squared logarithms of ours over printed."""
    return float((np.log(np.maximum(columns, 1e-3) / printed) ** 2).sum())


def centred_frame(directions: np.ndarray, roll: float) -> Frame:
    """A frame with a given roll in which the directions spread equally to both sides of the middle."""
    forward = unit(directions.mean(axis=0))
    right = unit(np.cross(forward, np.eye(3)[np.argmin(np.abs(forward))]))
    for _ in range(3):  # turning the frame changes the spread a little
        up = unit(math.cos(roll) * right + math.sin(roll) * np.cross(right, forward))
        side = np.cross(forward, up)
        x, y = tangents(directions, (side, up, forward))
        forward = unit(forward + 0.5 * (x.min() + x.max()) * side + 0.5 * (y.min() + y.max()) * up)
        right = unit(right - (right @ forward) * forward)
    up = unit(up - (up @ forward) * forward)
    return np.cross(forward, up), up, forward


def tangents(directions: np.ndarray, frame: Frame) -> tuple[np.ndarray, np.ndarray]:
    depth = np.maximum(directions @ frame[2], 1e-3)
    return directions @ frame[0] / depth, directions @ frame[1] / depth


def extent(directions: np.ndarray, frame: Frame) -> tuple[float, float]:
    x, y = tangents(directions, frame)
    return float(np.ptp(x)), float(np.ptp(y))


def aspect_of(directions: np.ndarray, frame: Frame) -> float:
    across, along = extent(directions, frame)
    return across / along


def rounded(vector: np.ndarray) -> np.ndarray:
    return np.round(np.asarray(vector, float), 4)


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
