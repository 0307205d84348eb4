"""Search views whose brute-force column comes near table 1's: `python calibrate.py ROW [SECONDS [SEED]]`.

Only the triangle count and the brute-force column of `printed.yaml` are aimed at; what depth bounds and the
hierarchical algorithm make of a view is never looked at. Views with less than LEAST_SHADOW of the picture in shadow, or
more than MOST_SHADOW, do not count. What SPACE names is drawn at random, at first anywhere, then in ever smaller
surroundings of the best view so far; when nothing better is found any more, or the view is good enough, the search
begins anew. Frames are drawn at half the resolution; what they move is scaled by what the row's present view moves at
both. Prints each better view as overrides.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml

from archsim.config import WalkthroughConfig, load_walkthrough
from archsim.raster.eye_view import eye_view
from archsim.run.shadow_volumes import method_of
from archsim.run.walkthrough import resources_of
from archsim.scene.scene import load_scene
from archsim.shadow_volumes.comparison import BRUTE_FORCE, draw, prepare

HERE = Path(__file__).resolve().parent
MB = 2**20
LEAST_SHADOW, MOST_SHADOW = 0.08, 0.9
GOOD = 0.02  # misfit
PATIENCE = 150  # frames without a better view
HALF = "scene.resolution=[640,512]"
COMMON = {  # lowest and highest value of what is searched, angles in degrees
    "eye_distance": (6.0, 30.0),
    "eye_elevation": (3.0, 60.0),
    "target_height": (0.0, 3.0),
    "fovy": (30.0, 75.0),
    "light_distance": (4.0, 60.0),
    "light_azimuth": (-180.0, 180.0),
    "light_elevation": (10.0, 90.0),
}
SPACE = {
    "simple": {**COMMON, "range": (6.0, 60.0), "mesh.height": (0.5, 5.0)},
    "knights": {
        **COMMON,
        "eye_elevation": (1.0, 40.0),
        "target_height": (0.0, 6.0),
        "range": (10.0, 200.0),
        "mesh.radius": (3.0, 25.0),
        "mesh.ground_half_size": (15.0, 80.0),
    },
    "powerplant": {
        **COMMON,
        "eye_distance": (12.0, 80.0),
        "eye_azimuth": (-180.0, 180.0),
        "target_height": (3.0, 30.0),
        "light_distance": (40.0, 150.0),
        "range": (60.0, 300.0),
    },
    "amphitheater": {
        **COMMON,
        "eye_elevation": (0.0, 25.0),
        "target_height": (0.0, 12.0),
        "fovy": (30.0, 80.0),
        "mesh.column_height": (3.0, 12.0),
        "mesh.stage_radius": (6.0, 14.0),
    },
}


class Quantities(NamedTuple):
    """What is aimed at."""

    triangles: float
    stencil: float  # MB
    depth: float
    lighting: float


class Found(NamedTuple):
    """A view that is better than those before it."""

    start: int  # how many times the search has begun anew
    misfit: float  # sum of squared logarithms of ours over the printed
    quantities: Quantities
    overrides: list[str]


def main() -> None:
    row, *numbers = sys.argv[1:]
    seconds = float(numbers[0]) if numbers else 120.0
    for found in search(row, seconds, int(numbers[1]) if len(numbers) > 1 else 0):
        pairs = zip(found.quantities, printed_column(row), strict=True)
        print(f"{found.start} {found.misfit:.4f}", " ".join(f"{ours:.4g}/{paper:g}" for ours, paper in pairs))
        print("  ", " ".join(f"--set '{each}'" for each in found.overrides), flush=True)


def search(row: str, seconds: float, seed: int) -> Iterator[Found]:
    """Each view that is better than all since the search began anew."""
    space, scale, aim = SPACE[row], _scale(row), np.array(printed_column(row))
    low, high = np.array(list(space.values())).T
    random = np.random.default_rng(seed)
    start, least, best, stale = 0, np.inf, None, 0
    deadline = time.perf_counter() + seconds
    while time.perf_counter() < deadline:
        if least < GOOD or stale > PATIENCE:
            start, least, best, stale = start + 1, np.inf, None, 0
        place = random.uniform(low, high)
        if best is not None and random.uniform() < 0.9:
            step = random.normal(0, 0.2 * 0.97**stale + 0.01, len(low)) * (high - low)
            place = np.clip(best + step * (random.uniform(size=len(low)) < 0.5), low, high)
        overrides = _overrides(dict(zip(space, place, strict=True)))
        quantities, shadow = brute_force(load_walkthrough(HERE / f"{row}.yaml", [*overrides, HALF]))
        quantities = Quantities(*(np.array(quantities) * scale))
        misfit = float(np.square(np.log((np.array(quantities) + 1e-9) / aim)).sum())
        stale += 1
        if misfit < least and LEAST_SHADOW <= shadow <= MOST_SHADOW:
            best, least, stale = place, misfit, 0
            yield Found(start, misfit, quantities, overrides)


def _scale(row: str) -> np.ndarray:
    """Quantities of the row's present view over those at half the resolution."""
    still = ["frames=1", "keyframes=[{}]"]
    whole, half = (
        brute_force(load_walkthrough(HERE / f"{row}.yaml", [*still, *more]))[0] for more in ([], [HALF])
    )
    return np.array(whole) / np.array(half)


def printed_column(row: str) -> Quantities:
    text = yaml.safe_load((HERE / "printed.yaml").read_text(encoding="utf-8"))
    table = text["table1"]
    rows = ("stencil_shadow_MB", "z_shadow_MB", "stencil_lighting_MB")
    return Quantities(
        text["scenes"][row]["sv_triangles_per_frame"], *(table[name][row]["BF"] for name in rows)
    )


def _overrides(values: dict[str, float]) -> list[str]:
    """The searched values as overrides of a walkthrough that stands still."""
    target = np.array([0.0, 0.0, values["target_height"]])
    eye = target + _polar(values["eye_distance"], values.get("eye_azimuth", -90.0), values["eye_elevation"])
    light = _polar(values["light_distance"], values["light_azimuth"], values["light_elevation"])
    changed = {
        "scene.camera.eye": _rounded(eye),
        "scene.camera.target": _rounded(target),
        "scene.camera.fovy_degrees": round(values["fovy"], 2),
        "scene.lights.0.position": _rounded(light),
        **{
            f"scene.mesh.parameters.{key[5:]}": round(value, 3)
            for key, value in values.items()
            if key[:5] == "mesh."
        },
        "frames": 1,
        "keyframes": "[{}]",
    }
    if "range" in values:
        changed["shadow_volumes.range"] = round(values["range"], 2)
    return [f"{key}={value}" for key, value in changed.items()]


def _polar(distance: float, azimuth: float, elevation: float) -> np.ndarray:
    across, up = np.cos(np.radians(elevation)), np.sin(np.radians(elevation))
    return distance * np.array(
        [across * np.cos(np.radians(azimuth)), across * np.sin(np.radians(azimuth)), up]
    )


def _rounded(point: np.ndarray) -> list[float]:
    return [round(float(number), 3) for number in point]


def brute_force(config: WalkthroughConfig) -> tuple[Quantities, float]:
    """The printed quantities of one frame, and the share of the picture that is in shadow."""
    scene, method = (
        load_scene(config.scene),
        method_of(config.shadow_volumes, resources_of(config.shadow_volumes)),
    )
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    view = prepare(scene, scene.lights[config.shadow_volumes.light].position, seen, method)
    drawn = draw(view, BRUTE_FORCE, method.resources)
    traffic, triangles = drawn.traffic, len(view.seen.volumes.triangles)
    moved = (traffic.stencil_shadow, traffic.depth_shadow, traffic.stencil_lighting)
    return Quantities(triangles, *(number / MB for number in moved)), float(drawn.shadow.mean())


if __name__ == "__main__":
    main()
