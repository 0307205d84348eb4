"""Search camera and lights on the stand-in scenes so that Table 1's workload columns come near the paper's.

Run: python experiments/johnson2004/calibrate.py doom|knot [--tries N] [--steps N] [--seed S]

Only Table 1 is looked at: cycles, latencies and useful cycles never enter. The best views found are printed as YAML
with the residual of each column. A view is scored at half the resolution on a grid of half the size, which leaves list
lengths alone and quarters every count.
"""

from __future__ import annotations

import argparse
import itertools
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml

from archsim import resources
from archsim.raster.eye_view import EyeView, eye_view
from archsim.scene.camera import Camera
from archsim.scene.generators import make_mesh
from archsim.scene.mesh import Mesh, load_mesh
from archsim.scene.scene import Light, LightView, Scene
from archsim.shadow.grid import Grid
from archsim.shadow.izb import in_shadow
from archsim.shadow.light_view import sample_points
from archsim.shadow.plain import Method, plan_faces, run_face
from archsim.shadow.workload import NOTHING, IzbWorkload

PRINTED = yaml.safe_load((Path(__file__).parent / "printed.yaml").read_text())["table1_workload"]
SCALE = 2  # of the resolution and the grid while searching
WIDEST_HALF_ANGLE = 65.0
SHADOWED = (0.15, 0.85)  # share of pixels in shadow: outside, a view would not show what the paper is about
UNFIT = 100.0  # misfit of a view that will not do


class View(NamedTuple):
    """A camera, a light with its view, and how far their workload is from the paper's row."""

    camera: Camera
    light: Light
    workload: IzbWorkload
    misfit: float


class Stage(NamedTuple):
    """A mesh to look at, the rows of Table 1 to come near to, and where lights may stand."""

    mesh: Mesh
    rows: tuple[str, ...]  # one light each, one camera for all
    lights: np.ndarray | None  # float64 [n, 3] the level's own, None: anywhere
    reach: float  # how far from a light a camera is tried
    fewest_visible: int  # triangles that a picture must show, or it is of a bare wall


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", choices=["doom", "knot"])
    parser.add_argument("--tries", type=int, default=300, help="cameras tried at random")
    parser.add_argument("--steps", type=int, default=300, help="small changes tried on the best one")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    search(stage_of(options.scene), options.tries, options.steps, np.random.default_rng(options.seed))


def stage_of(scene: str) -> Stage:
    if scene == "doom":
        level = load_mesh("nx_bloodprison_8k9")
        lights = np.load(resources.mesh("nx_bloodprison_8k9"))["lights"][:, :3].astype(float)
        return Stage(level, ("doom_light0", "doom_light1"), lights, 300.0, 250)
    knot = make_mesh("knot_and_spheres", 0, {})
    return Stage(knot, ("knot_light0",), None, float(np.ptp(knot.vertices, axis=0).max()) / 4, 400)


def search(stage: Stage, tries: int, steps: int, rng: np.random.Generator) -> None:
    """Random cameras first, then a walk downhill from the best; every improvement is printed."""
    best: list[View] = []
    for _ in range(tries):
        lights = random_lights(stage, rng)
        best = better(stage, best, evaluated(stage, random_camera(stage, lights, rng), lights))
    for step in range(steps if best else 0):
        size = 0.3 * 0.99**step
        lights = np.array([view.light.position for view in best])
        if stage.lights is None:
            lights = lights + size * stage.reach * rng.normal(0, 0.3, lights.shape)
        best = better(stage, best, evaluated(stage, jittered(best[0].camera, size, rng), lights))


def better(stage: Stage, best: list[View], found: list[View]) -> list[View]:
    """The better of two; an improvement is printed."""
    if not found or (best and total(found) >= total(best)):
        return best
    for row, view in zip(stage.rows, found, strict=True):
        show(row, view)
    return found


def total(views: list[View]) -> float:
    return sum(view.misfit for view in views)


def evaluated(stage: Stage, camera: Camera, lights: np.ndarray) -> list[View]:
    """The best view of each row, every row with a light of its own; empty if there are too few fitting lights."""
    fitting = [light for light in lights if fits(stage, camera, light)]
    if len(fitting) < len(stage.rows):
        return []
    views = [
        [fitted_view(stage.mesh, camera, light, PRINTED[row]) for light in fitting] for row in stage.rows
    ]
    choices = itertools.permutations(range(len(fitting)), len(stage.rows))
    picked = ([row[light] for row, light in zip(views, choice, strict=True)] for choice in choices)
    return min(picked, key=total)


def random_lights(stage: Stage, rng: np.random.Generator) -> np.ndarray:
    """Candidate positions float64 [n, 3]."""
    if stage.lights is not None:
        return stage.lights
    low, high = stage.mesh.vertices.min(axis=0), stage.mesh.vertices.max(axis=0)
    return low + (high - low) * rng.uniform(0.05, 0.95, (len(stage.rows), 3))


def random_camera(stage: Stage, lights: np.ndarray, rng: np.random.Generator) -> Camera:
    """A camera somewhere near a light, looking anywhere but steeply."""
    eye = lights[rng.integers(len(lights))] + rng.uniform(-1, 1, 3) * stage.reach * (1, 1, 1 / 3)
    yaw, pitch = rng.uniform(0, 2 * math.pi), rng.uniform(-0.6, 0.3)
    forward = np.array([math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch)])
    target = eye + forward * stage.reach
    return Camera(eye, target, np.array([0.0, 0.0, 1.0]), float(rng.uniform(45, 90)), stage.reach / 150)


def jittered(camera: Camera, size: float, rng: np.random.Generator) -> Camera:
    """A camera a little beside another one."""
    length = float(np.linalg.norm(camera.target - camera.eye))
    eye = camera.eye + size * length * rng.normal(0, 0.3, 3)
    target = camera.target + size * length * rng.normal(0, 0.3, 3)
    fovy = float(np.clip(camera.fovy_degrees + size * rng.normal(0, 10), 40, 95))
    return camera._replace(eye=eye, target=target, fovy_degrees=fovy)


def fits(stage: Stage, camera: Camera, light: np.ndarray) -> bool:
    """Whether every pixel shows the front of something, not too near, and one view of the light holds it all."""
    mesh = stage.mesh
    scene = Scene(mesh, camera, (), 160, 128, "probe")
    view = eye_view(mesh, camera, scene.width, scene.height)
    if (view.triangle < 0).any() or np.median(1 / view.reciprocal_depth) < 20 * camera.near:
        return False
    if len(np.unique(view.triangle)) < stage.fewest_visible:
        return False
    corners = mesh.vertices[mesh.triangles[view.triangle.ravel()]].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = np.einsum("nk,nk->n", normals, corners[:, 0] - camera.eye) > 0
    if 0.02 < facing.mean() < 0.98:
        return False
    directions = unit((sample_points(scene, view) - light).reshape(-1, 3))
    return bool(
        (directions @ unit(directions.mean(axis=0))).min() > math.cos(math.radians(WIDEST_HALF_ANGLE))
    )


def fitted_view(mesh: Mesh, camera: Camera, light: np.ndarray, row: dict) -> View:
    """The light view whose roll and field of view give the stencil about the printed extent."""
    scene = Scene(mesh, camera, (), 1280 // SCALE, 1024 // SCALE, "search")
    seen = eye_view(mesh, camera, scene.width, scene.height)
    directions = unit((sample_points(scene, seen) - light)[::8, ::8].reshape(-1, 3))
    aspect = row["stencil"][0] / row["stencil"][1]
    frames = [centred_frame(directions, roll) for roll in np.linspace(0, math.pi, 24, endpoint=False)]
    side, up, forward = min(frames, key=lambda frame: abs(math.log(aspect_of(directions, frame) / aspect)))

    across, along = extent(directions, (side, up, forward))
    wanted = math.sqrt(across * along / (row["stencil"][0] * row["stencil"][1])) * 1024 / 2
    fovy = 2 * math.degrees(math.atan(max(wanted, 0.51 * max(across, along))))
    view = Light(light, LightView(light + forward, up, fovy))
    workload, shadowed = measure(scene, seen, view)
    will_do = SHADOWED[0] <= shadowed <= SHADOWED[1]
    return View(camera, view, workload, misfit(workload, row) if will_do else UNFIT)


Frame = tuple[np.ndarray, np.ndarray, np.ndarray]  # side, up, forward


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
    depth = directions @ frame[2]
    return directions @ frame[0] / depth, directions @ frame[1] / depth


def extent(directions: np.ndarray, frame: Frame) -> tuple[float, float]:
    x, y = tangents(directions, frame)
    return float(np.ptp(x)), float(np.ptp(y))


def aspect_of(directions: np.ndarray, frame: Frame) -> float:
    across, along = extent(directions, frame)
    return across / along


def measure(scene: Scene, seen: EyeView, light: Light) -> tuple[IzbWorkload, float]:
    """Table 1's columns, scaled to the full resolution, and the share in shadow; nothing if one view does not do."""
    grid = Grid(1024 // SCALE, 1024 // SCALE, 512 // SCALE, 512 // SCALE, 8, 8)
    plans = plan_faces(scene, seen, light, Method(grid, (8, 8), 1 / 64))
    if len(plans) != 1:
        return NOTHING, 0.0
    outcome = run_face(plans[0], grid)
    found = outcome.workload
    counts = IzbWorkload(*(value * SCALE * SCALE for value in found))
    width, height = found.stencil_width * SCALE, found.stencil_height * SCALE
    shadowed = float(in_shadow(outcome.z_test, outcome.samples).mean())
    return counts._replace(stencil_width=width, stencil_height=height), shadowed


def columns(workload: IzbWorkload) -> dict[str, float]:
    return {
        "list length": workload.list_length,
        "stencil width": workload.stencil_width,
        "stencil height": workload.stencil_height,
        "grid fragments pre": workload.grid_fragments_pre_stencil / 1e6,
        "grid fragments post": workload.grid_fragments_post_stencil / 1e6,
        "framebuffer fragments pre": workload.framebuffer_fragments_pre_z / 1e6,
        "framebuffer fragments post": workload.framebuffer_fragments_post_z / 1e6,
    }


def printed_columns(row: dict) -> dict[str, float]:
    grid, frame = row["grid_fragments_M"], row["framebuffer_fragments_M"]
    values = [row["list_length"], *row["stencil"], grid["pre"], grid["post"], frame["pre_z"], frame["post_z"]]
    return dict(zip(columns(NOTHING), values, strict=True))


def misfit(workload: IzbWorkload, row: dict) -> float:
    """Sum of squared logarithms of ours over printed."""
    ours, printed = columns(workload), printed_columns(row)
    return sum(math.log(max(ours[name], 1e-3) / printed[name]) ** 2 for name in printed)


def show(name: str, view: View) -> None:
    """Print a view as YAML with its residuals."""
    ours, printed = columns(view.workload), printed_columns(PRINTED[name])
    print(f"# {name}: misfit {view.misfit:.3f}")
    for column in ours:
        error = 100 * (ours[column] / printed[column] - 1)
        print(f"#   {column:27} {ours[column]:9.2f}  printed {printed[column]:9.2f}  {error:+6.1f} %")
    camera, light = view.camera, view.light
    assert light.view is not None
    document = {
        "camera": {
            "eye": rounded(camera.eye),
            "target": rounded(camera.target),
            "up": rounded(camera.up),
            "fovy_degrees": round(camera.fovy_degrees, 3),
            "near": round(camera.near, 4),
        },
        "lights": [
            {
                "position": rounded(light.position),
                "view": {
                    "target": rounded(light.view.target),
                    "up": rounded(light.view.up),
                    "fovy_degrees": round(light.view.fovy_degrees, 3),
                },
            }
        ],
    }
    print(yaml.safe_dump(document, sort_keys=False, default_flow_style=None), flush=True)


def rounded(vector: np.ndarray) -> list[float]:
    return [round(float(value), 4) for value in vector]


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


if __name__ == "__main__":
    main()
