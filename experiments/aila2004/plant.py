"""Where someone walks in the power plant, and where its light is: the rules of calibrate.py's search for that row.

Someone walks 5 to 20 units straight ahead, on the walkway of one of the floors, which pipes leave free, or on the
ground before the frame, 1 to 12 units from it. The eye is 1.5 to 1.9 units above what is walked on, an arm's length or
more from all solids, and looks at one thing within the frame, 4 units away or more, at most 30 degrees up or down.

The light is the sun's or a floodlight's, outside, 20 to 75 degrees high seen from the middle of the plant, and moves
around it, or a lamp that someone else carries along a walkway. It lights all of the plant: its range reaches at least
to the farthest corner of the frame, and at most ten times as far.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import trimesh

from archsim.config import WalkthroughConfig
from archsim.scene.generators.power_plant import Parameters, walkway_middle
from archsim.scene.mesh import Mesh

KEYFRAMES = 9
LIGHT_SWEEP = 40.0  # degrees
WALKWAY = 2.6
ARMS_LENGTH = 0.5
AROUND = 1.5  # of the eye, in which solids are looked for
STRIDES = 10  # from keyframe to keyframe, at which the eye's surroundings are looked at
STEEPEST = 30.0  # degrees, of a look up or down
LEAST_VIEW = 4.0
LAMP_HEIGHT = 1.9
SPACE = {
    "storey": (-1.0, 6.0),  # below 0: on the ground before the frame
    "across": (0.0, 1.0),  # of where one may walk
    "start": (-1.0, 1.0),  # from one end of the frame to the other
    "walk": (5.0, 20.0),
    "eye_height": (1.5, 1.9),
    "target_x": (-1.0, 1.0),
    "target_y": (-1.0, 1.0),
    "target_rise": (-6.0, 10.0),  # over the eye
    "fovy": (35.0, 65.0),
    "lamp": (0.0, 1.0),  # the sun if less than half
    "light_azimuth": (-180.0, 180.0),
    "light_height": (0.0, 1.0),
    "light_distance": (1.0, 4.0),  # the sun's, of the plant's half diagonal
    "range": (1.0, 10.0),  # of the distance to the farthest corner
}


def overrides_of(values: Mapping[str, float], mesh: Mapping[str, Any]) -> list[str]:
    """What is searched as overrides of the walkthrough; `mesh`: the parameters of its present one."""
    parameters = Parameters(**dict(mesh) | {"walkway": WALKWAY})
    eye, target = _eyes(values, parameters), _target(values, parameters)
    light = _lights(values, parameters)
    farthest = np.linalg.norm(_corners(parameters)[:, None] - light, axis=-1).max()
    frames = [
        f"{{eye: {_rounded(own)}, light: {_rounded(lamp)}}}" for own, lamp in zip(eye, light, strict=True)
    ]
    changed = {
        "scene.mesh.parameters.walkway": WALKWAY,
        "scene.camera.target": _rounded(target),
        "scene.camera.fovy_degrees": f"{values['fovy']:.2f}",
        "shadow_volumes.range": int(np.ceil(farthest * values["range"])),
        "keyframes": f"[{', '.join(frames)}]",
    }
    return [f"{key}={value}" for key, value in changed.items()]


def _eyes(values: Mapping[str, float], parameters: Parameters) -> np.ndarray:
    """float64 [KEYFRAMES, 3]."""
    half = 0.5 * parameters.bays * parameters.bay_size
    storey = min(int(np.floor(values["storey"])), parameters.floors - 1)
    y = _walk(values["start"] * half, values["walk"], half)
    if storey < 0:
        x, below = -half - 1 - 11 * values["across"], 0.0
    else:
        x = walkway_middle(parameters) + (values["across"] - 0.5) * (WALKWAY - 2 * ARMS_LENGTH)
        below = storey * parameters.bay_size
    return np.stack([np.full_like(y, x), y, np.full_like(y, below + values["eye_height"])], axis=1)


def _walk(start: float, length: float, half: float) -> np.ndarray:
    """From start to the other end, [KEYFRAMES], begun earlier if that is nearer than the walk is long."""
    begin = np.copysign(max(abs(start), length - half), start)
    return np.asarray(begin - np.copysign(length, start) * np.linspace(0, 1, KEYFRAMES))


def _target(values: Mapping[str, float], parameters: Parameters) -> np.ndarray:
    half = 0.5 * parameters.bays * parameters.bay_size
    height = _eyes(values, parameters)[0, 2] + values["target_rise"]
    return np.array([values["target_x"] * half, values["target_y"] * half, max(height, 0.0)])


def _lights(values: Mapping[str, float], parameters: Parameters) -> np.ndarray:
    """float64 [KEYFRAMES, 3]."""
    half, height = 0.5 * parameters.bays * parameters.bay_size, parameters.floors * parameters.bay_size
    time = np.linspace(0, 1, KEYFRAMES)
    if values["lamp"] >= 0.5:
        y = _walk(half * values["light_azimuth"] / 180, 5 * values["light_distance"], half)
        storey = min(int(values["light_height"] * parameters.floors), parameters.floors - 1)
        z = np.full_like(y, storey * parameters.bay_size + LAMP_HEIGHT)
        return np.stack([np.full_like(y, walkway_middle(parameters)), y, z], axis=1)
    distance = values["light_distance"] * np.hypot(np.sqrt(2) * half, 0.5 * height)
    turn = np.radians(values["light_azimuth"] + time * LIGHT_SWEEP)
    rise = np.radians(20 + 55 * values["light_height"])
    x, y = distance * np.cos(rise) * np.cos(turn), distance * np.cos(rise) * np.sin(turn)
    return np.stack([x, y, np.full_like(x, 0.5 * height + distance * np.sin(rise))], axis=1)


def _corners(parameters: Parameters) -> np.ndarray:
    """float64 [8, 3] of the frame."""
    half, height = 0.5 * parameters.bays * parameters.bay_size, parameters.floors * parameters.bay_size
    return np.array([(x, y, z) for x in (-half, half) for y in (-half, half) for z in (0.0, height)])


def _rounded(point: np.ndarray) -> list[float]:
    return [round(float(number), 2) for number in point]


def keeps_rules(config: WalkthroughConfig, mesh: Mesh) -> bool:
    """Whether the eye is clear of solids on all its way, and does not look too steeply or at what is too near."""
    way = _way(config)
    scene: Any = config.scene
    sight = np.asarray(scene.camera.target) - way
    level = np.linalg.norm(sight[:, :2], axis=1)
    steepness = np.degrees(np.arctan2(np.abs(sight[:, 2]), level))
    if steepness.max() > STEEPEST or np.linalg.norm(sight, axis=1).min() < LEAST_VIEW:
        return False
    return clearance(way, mesh) >= ARMS_LENGTH


def _way(config: WalkthroughConfig) -> np.ndarray:
    """float64 [n, 3]: where the eye is, keyframes and between."""
    eyes = np.array([keyframe.eye for keyframe in config.keyframes])
    share = np.arange(STRIDES)[:, None, None] / STRIDES
    return np.concatenate([((1 - share) * eyes[:-1] + share * eyes[1:]).reshape(-1, 3), eyes[-1:]])


def clearance(way: np.ndarray, mesh: Mesh) -> float:
    """Least distance of places [n, 3] from solids, or AROUND if none is as near as that."""
    assert mesh.objects is not None
    corners = mesh.vertices.astype(np.float64)[mesh.triangles[mesh.objects >= 0]]
    near = (corners.max(axis=1) >= way.min(axis=0) - AROUND) & (
        corners.min(axis=1) <= way.max(axis=0) + AROUND
    )
    corners = corners[near.all(axis=1)]
    return min([AROUND, *(float(_distances(place, corners).min(initial=AROUND)) for place in way)])


def _distances(place: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance [n] of a place from triangles [n, 3, 3]."""
    nearest = trimesh.triangles.closest_point(corners, np.broadcast_to(place, (len(corners), 3)))
    return np.asarray(np.linalg.norm(nearest - place, axis=1))
