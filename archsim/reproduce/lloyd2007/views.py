"""What the experiment looks at: scenes, camera paths, lights. `experiments/lloyd2007/views.yaml` holds them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import yaml

from archsim import resources
from archsim.scene.camera import Camera
from archsim.scene.generators import make_mesh
from archsim.scene.mesh import Mesh
from archsim.shadowmap.view import View, directional_light, make_view

ID = "lloyd2007"
SCENES = ("town", "robots", "power_plant")
UP = np.array([0.0, 0.0, 1.0])


class Frame(NamedTuple):
    """One frame of a camera path."""

    camera: Camera
    view: View
    light: np.ndarray  # float64 [4]


class Walk(NamedTuple):
    """A scene and the frames of the way through it."""

    mesh: Mesh
    frames: list[Frame]


def load_walk(scene: str) -> Walk:
    """One of SCENES."""
    text = (resources.experiment(ID) / "views.yaml").read_text(encoding="utf-8")
    chosen = yaml.safe_load(text)[scene]
    light = directional_light(np.array(chosen["light"], dtype=np.float64))
    frames = []
    for eye, target in chosen["path"]:
        place = np.array(eye, dtype=np.float64), np.array(target, dtype=np.float64)
        camera = Camera(*place, UP, chosen["fovy_degrees"], chosen["near"])
        frames.append(Frame(camera, make_view(camera, 1.0, chosen["far"]), light))
    return Walk(make_mesh(scene, 0, {}), frames)
