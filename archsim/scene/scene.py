"""A scene: one mesh, one camera, point lights and the resolution of the image."""

from __future__ import annotations

import hashlib
from typing import Any, NamedTuple

import numpy as np

from archsim.errors import about
from archsim.scene.camera import Camera
from archsim.scene.generators import make_mesh
from archsim.scene.mesh import Mesh, load_mesh


class LightView(NamedTuple):
    """How the image plane of a light is turned; its eye is the light."""

    target: np.ndarray  # float64 [3]
    up: np.ndarray  # float64 [3]
    fovy_degrees: float


class Light(NamedTuple):
    """A point light."""

    position: np.ndarray  # float64 [3]
    view: LightView | None  # None: chosen by whoever needs one


class Scene(NamedTuple):
    """Everything that decides the picture."""

    mesh: Mesh
    camera: Camera
    lights: tuple[Light, ...]
    width: int  # pixel columns
    height: int  # pixel rows
    name: str


def load_scene(config: Any) -> Scene:
    """The scene that a checked SceneConfig describes; raises ArchsimError if its mesh cannot be had."""
    with about("scene.mesh"):
        if isinstance(config.mesh, str):
            mesh = load_mesh(config.mesh)
        else:
            mesh = make_mesh(config.mesh.generator, config.mesh.seed, config.mesh.parameters)
    width, height = config.resolution
    return Scene(
        mesh=mesh,
        camera=_camera(config.camera),
        lights=tuple(_light(light) for light in config.lights),
        width=int(width),
        height=int(height),
        name=config.name,
    )


def digest(scene: Scene) -> str:
    """SHA-256, in hexadecimal, of geometry, camera, lights and resolution; the name does not count."""
    views = [light.view for light in scene.lights]
    numbers = [
        *(np.asarray(part, dtype="<f8") for part in scene.camera),
        *(np.asarray(light.position, dtype="<f8") for light in scene.lights),
        *(np.asarray(part, dtype="<f8") for view in views if view for part in view),
        np.array([scene.width, scene.height, len(views), *(view is not None for view in views)], dtype="<i8"),
        np.asarray(scene.mesh.vertices, dtype="<f4"),
        np.asarray(scene.mesh.triangles, dtype="<i4"),
    ]
    if scene.mesh.objects is not None:
        numbers.append(np.asarray(scene.mesh.objects, dtype="<i4"))
    total = hashlib.sha256()
    for array in numbers:
        total.update(f"{array.dtype.str}{array.shape}".encode())
        total.update(array.tobytes())
    return total.hexdigest()


def _camera(config: Any) -> Camera:
    return Camera(
        _point(config.eye),
        _point(config.target),
        _point(config.up),
        float(config.fovy_degrees),
        float(config.near),
    )


def _light(config: Any) -> Light:
    view = config.view and LightView(
        _point(config.view.target), _point(config.view.up), float(config.view.fovy_degrees)
    )
    return Light(_point(config.position), view)


def _point(numbers: Any) -> np.ndarray:
    return np.array(numbers, dtype=np.float64)
