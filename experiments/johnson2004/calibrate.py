"""Search camera, lights and generator parameters so that Table 1's workload columns come near the paper's.

Run: python experiments/johnson2004/calibrate.py doom|knot [--tries N] [--steps N] [--seed S] [--start SCENE]

Only Table 1 is looked at: cycles, latencies and useful cycles never enter. The same options give the same views: random
views at an eighth of the resolution, or the view of a scene file, walks downhill from the best few, and a last walk at
a half. What is found is printed as YAML with the residual of each column.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from light_fit import COLUMNS, fitted_light, measure, misfit, printed_columns, rounded, unit

from archsim import resources
from archsim.config import load_scene as load_config
from archsim.raster.eye_view import EyeView, eye_view
from archsim.scene.camera import Camera
from archsim.scene.generators import make_mesh
from archsim.scene.mesh import Mesh, load_mesh
from archsim.scene.scene import Light, Scene, load_scene
from archsim.shadow.light_view import sample_points

PRINTED = yaml.safe_load((Path(__file__).parent / "printed.yaml").read_text())["table1_workload"]
COARSE, FINE = 8, 2  # parts of the resolution
NUM_WALKS = 4  # of the best random views, each is walked downhill
WIDEST_HALF_ANGLE = 65.0
SHADOWED = (0.15, 0.85)  # share of pixels in shadow: outside, a view would not show what the paper is about
LARGEST_SHARE = 0.4  # of the pixels that one triangle may fill: more is a picture of a wall


class Guess(NamedTuple):
    """A point of the search: numbers between 0 and 1, and choices that are drawn once."""

    numbers: np.ndarray  # float64 [n]
    choices: tuple[int, ...]


class Stage(NamedTuple):
    """A mesh to look at, and lights that may stand anywhere of these places."""

    mesh: Mesh
    camera: Camera
    lights: np.ndarray  # float64 [n, 3]
    described: dict[str, Any]  # the mesh as a scene's YAML names it


class Theme(NamedTuple):
    """What is searched: the rows of Table 1, one light each and one camera for all, and how a guess becomes a stage."""

    rows: tuple[str, ...]
    num_numbers: int
    num_choices: tuple[int, ...]
    stage: Callable[[Guess], Stage]
    fewest_visible: int  # triangles that a picture must show
    num_subject: int  # the first so many triangles are what the picture is of, seen from outside
    least_subject: float  # share of the pixels that must show them


class View(NamedTuple):
    """A stage with a light for each row, and how far their workload is from the paper's."""

    stage: Stage
    lights: list[Light]
    columns: list[np.ndarray]
    misfits: list[float]

    @property
    def total(self) -> float:
        return sum(self.misfits)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", choices=sorted(THEMES))
    parser.add_argument("--tries", type=int, default=6000, help="random views")
    parser.add_argument("--steps", type=int, default=300, help="steps of each walk")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--start", help="a scene of the level to walk from, instead of random views")
    options = parser.parse_args()
    theme, rng = THEMES[options.scene](), np.random.default_rng(options.seed)
    if options.start:
        starts = [guess_of(load_scene(load_config(options.start)))]
    else:
        starts = random_starts(theme, options.tries, rng)
    best = search(theme, starts, options.steps, rng)
    show(theme, best)


def search(theme: Theme, starts: list[Guess], steps: int, rng: np.random.Generator) -> View:
    """Walks from a few views, one last walk from the best of them."""
    walked = [walk(theme, guess, COARSE, steps, rng) for guess in starts]
    _, best = min(walked, key=lambda pair: pair[0].total)
    return walk(theme, best, FINE, steps // 4, rng)[0]


def random_starts(theme: Theme, tries: int, rng: np.random.Generator) -> list[Guess]:
    """The best few of so many random views."""
    found: list[tuple[float, int, Guess]] = []
    for number in range(tries):
        guess = random_guess(theme, rng)
        view = evaluated(theme, guess, COARSE)
        if view is not None:
            found.append((view.total, number, guess))
    return [guess for _, _, guess in sorted(found, key=lambda each: each[:2])[:NUM_WALKS]]


def random_guess(theme: Theme, rng: np.random.Generator) -> Guess:
    choices = tuple(int(rng.integers(number)) for number in theme.num_choices)
    return Guess(rng.uniform(0, 1, theme.num_numbers), choices)


def walk(theme: Theme, guess: Guess, scale: int, steps: int, rng: np.random.Generator) -> tuple[View, Guess]:
    """Small random changes, kept when they help; steps grow on success and shrink on failure."""
    view = evaluated(theme, guess, scale)
    lights = None if view is None else np.array([light.position for light in view.lights])
    size = 0.1 if scale == COARSE else 0.01
    for _ in range(steps):
        moved = guess.numbers + size * rng.normal(0, 1, theme.num_numbers) * (
            rng.random(theme.num_numbers) < 0.5
        )
        candidate = guess._replace(numbers=np.clip(moved, 0, 1))
        other = evaluated(theme, candidate, scale, lights)
        if other is not None and (view is None or other.total < view.total):
            view, guess, size = other, candidate, size * 1.5
        else:
            size = max(size * 0.96, 1e-4)
    assert view is not None
    print(f"# walk at 1/{scale} of the resolution: misfit {view.total:.3f}", flush=True)
    return view, guess


def evaluated(theme: Theme, guess: Guess, scale: int, lights: np.ndarray | None = None) -> View | None:
    """The best lights for a guess's picture; None if it is not a picture to show, or too few lights suit it.

    `lights`: where a level's lights to choose from are; by default all that the stage has.
    """
    stage = theme.stage(guess)
    if lights is not None and len(stage.lights) > len(lights):
        stage = stage._replace(lights=lights)
    scene = Scene(stage.mesh, stage.camera, (), 1280 // scale, 1024 // scale, "search")
    seen = eye_view(stage.mesh, stage.camera, scene.width, scene.height)
    if not is_picture(theme, stage, seen):
        return None
    points = sample_points(scene, seen)
    fitting = [light for light in stage.lights if lights_all(points, light)]
    if len(fitting) < len(theme.rows):
        return None
    options = [[scored(scene, seen, light, PRINTED[row], scale) for light in fitting] for row in theme.rows]
    orders = itertools.permutations(range(len(fitting)), len(theme.rows))
    views = ([row[k] for row, k in zip(options, order, strict=True)] for order in orders)
    whole = [view for view in views if all(view)]
    if not whole:
        return None
    best = min(whole, key=lambda view: sum(each[2] for each in view))
    return View(stage, [each[0] for each in best], [each[1] for each in best], [each[2] for each in best])


def scored(
    scene: Scene, seen: EyeView, position: np.ndarray, row: dict, scale: int
) -> tuple[Light, np.ndarray, float] | None:
    """A light fitted for a row, its columns and its misfit; None if its picture will not do."""
    light = fitted_light(scene, seen, position, row["stencil"])
    measured = measure(scene, seen, light, scale)
    if measured is None or not SHADOWED[0] <= measured.shadowed <= SHADOWED[1]:
        return None
    return light, measured.columns, misfit(measured.columns, printed_columns(row))


def is_picture(theme: Theme, stage: Stage, seen: EyeView) -> bool:
    """Whether every pixel shows something, not too near, the subject from outside, and not just one triangle."""
    if (seen.triangle < 0).any() or np.median(1 / seen.reciprocal_depth) < 20 * stage.camera.near:
        return False
    visible, counts = np.unique(seen.triangle, return_counts=True)
    if len(visible) < theme.fewest_visible or counts.max() > LARGEST_SHARE * seen.triangle.size:
        return False
    subject = visible < theme.num_subject
    corners = stage.mesh.vertices[stage.mesh.triangles[visible]].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = np.einsum("nk,nk->n", normals, stage.camera.eye - corners[:, 0]) > 0
    shown = counts[subject].sum()
    in_front = counts[subject & front].sum() / max(shown, 1)
    return shown >= theme.least_subject * counts.sum() and (in_front < 0.02 or in_front > 0.98)


def lights_all(points: np.ndarray, light: np.ndarray) -> bool:
    """Whether one view of the light holds all points."""
    directions = unit((points - light).reshape(-1, 3))
    return bool(
        (directions @ unit(directions.mean(axis=0))).min() > math.cos(math.radians(WIDEST_HALF_ANGLE))
    )


def camera_of(numbers: np.ndarray, centre: np.ndarray, reach: np.ndarray) -> Camera:
    """A camera near a place, looking anywhere but steeply, from six numbers."""
    eye = rounded(centre + (2 * numbers[:3] - 1) * reach)
    yaw, pitch = 2 * math.pi * numbers[3], -0.7 + 1.1 * numbers[4]
    forward = np.array([math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch)])
    target = rounded(eye + forward * reach[0])
    return Camera(
        eye, target, np.array([0.0, 0.0, 1.0]), round(45 + 45 * float(numbers[5]), 3), float(reach[0]) / 150
    )


LEVEL = "nx_bloodprison_8k9"
REACH = np.array([300.0, 300.0, 100.0])  # of a camera from the light that it is tried near to


def doom_theme() -> Theme:
    """The level with its own lights."""
    level = load_mesh(LEVEL)
    lights = np.load(resources.mesh(LEVEL))["lights"][:, :3].astype(float).round(4)

    def stage(guess: Guess) -> Stage:
        return Stage(
            level, camera_of(guess.numbers, lights[guess.choices[0]], REACH), lights, {"mesh": LEVEL}
        )

    return Theme(("doom_light0", "doom_light1"), 6, (len(lights),), stage, 250, len(level.triangles), 1.0)


def guess_of(scene: Scene) -> Guess:
    """The guess that gives about the camera of a scene of the level: its eye is near one of the level's lights."""
    lights = np.load(resources.mesh(LEVEL))["lights"][:, :3].astype(float).round(4)
    away = np.abs(scene.camera.eye - lights) / REACH
    light = int(away.max(axis=1).argmin())
    forward = unit(scene.camera.target - scene.camera.eye)
    yaw, pitch = math.atan2(forward[1], forward[0]) % (2 * math.pi), math.asin(forward[2])
    place = ((scene.camera.eye - lights[light]) / REACH + 1) / 2
    numbers = [*place, yaw / (2 * math.pi), (pitch + 0.7) / 1.1, (scene.camera.fovy_degrees - 45) / 45]
    return Guess(np.array(numbers), (light,))


TURNS = ((2, 3), (3, 2), (2, 5), (3, 4), (3, 5))
RANGES = {  # of the generator's parameters; counts stay, so that there are 16,372 triangles
    "knot_radius": (1.0, 3.0),
    "winding_radius": (0.3, 1.4),
    "tube_radius": (0.1, 0.6),
    "sphere_radius": (0.2, 1.2),
    "room_half_size": (4.0, 8.0),
}
NUM_ROOM_TRIANGLES = 12
LEAST_SUBJECT = 0.25  # share of the pixels that show the knot or a sphere


def knot_theme() -> Theme:
    """The knot and its spheres, of any shape, in a room; the light anywhere in it."""

    def stage(guess: Guess) -> Stage:
        seed, turns = guess.choices
        parameters: dict[str, float] = dict(
            zip(("turns_around_axis", "turns_around_core"), TURNS[turns], strict=True)
        )
        for number, (name, (low, high)) in zip(guess.numbers[9:], RANGES.items(), strict=True):
            parameters[name] = round(low + (high - low) * float(number), 3)
        half = parameters["room_half_size"]
        camera = camera_of(guess.numbers[:6], np.zeros(3), np.full(3, 0.9 * half))
        light = rounded((2 * guess.numbers[6:9] - 1) * 0.95 * half)
        mesh = make_mesh("knot_and_spheres", seed, parameters)
        described = {"generator": "knot_and_spheres", "seed": seed, "parameters": parameters}
        return Stage(mesh, camera, light[None], {"mesh": described})

    num_subject = len(make_mesh("knot_and_spheres", 0, {}).triangles) - NUM_ROOM_TRIANGLES
    return Theme(("knot_light0",), 9 + len(RANGES), (16, len(TURNS)), stage, 400, num_subject, LEAST_SUBJECT)


THEMES: dict[str, Callable[[], Theme]] = {"doom": doom_theme, "knot": knot_theme}


def show(theme: Theme, view: View) -> None:
    """Print the view as the YAML of a scene, with its residuals."""
    for row, ours, total in zip(theme.rows, view.columns, view.misfits, strict=True):
        print(f"# {row}: misfit {total:.3f}")
        for column, value, printed in zip(COLUMNS, ours, printed_columns(PRINTED[row]), strict=True):
            print(
                f"#   {column:27} {value:9.2f}  printed {printed:9.2f}  {100 * (value / printed - 1):+6.1f} %"
            )
    camera = view.stage.camera
    document = {
        **view.stage.described,
        "camera": {
            "eye": camera.eye.tolist(),
            "target": camera.target.tolist(),
            "up": camera.up.tolist(),
            "fovy_degrees": camera.fovy_degrees,
            "near": round(camera.near, 4),
        },
        "lights": [described_light(light) for light in view.lights],
    }
    print(yaml.safe_dump(document, sort_keys=False, default_flow_style=None), flush=True)


def described_light(light: Light) -> dict[str, Any]:
    assert light.view is not None
    view = {
        "target": light.view.target.tolist(),
        "up": light.view.up.tolist(),
        "fovy_degrees": light.view.fovy_degrees,
    }
    return {"position": light.position.tolist(), "view": view}


if __name__ == "__main__":
    main()
