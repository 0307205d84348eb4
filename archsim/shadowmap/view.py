"""The view frustum that shadow maps are fitted to, and lights as homogeneous points."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.scene.camera import Camera, camera_axes

_SLACK = 1e-9  # of the far depth


class View(NamedTuple):
    """A frustum: what a camera sees between two depths."""

    eye: np.ndarray  # float64 [3]
    axes: np.ndarray  # float64 [3, 3] rows right, up, forward
    tan_x: float  # of half the horizontal angle
    tan_y: float  # of half the vertical angle
    near: float
    far: float

    @property
    def ratio(self) -> float:
        return self.far / self.near


def make_view(camera: Camera, aspect: float, far: float) -> View:
    """The frustum of a camera up to depth `far`; `aspect` is width over height."""
    if not 0 < camera.near < far < math.inf:
        raise fail(f"a view needs 0 < near < far; they are {camera.near} and {far}")
    tan_y = math.tan(math.radians(camera.fovy_degrees) / 2)
    eye = np.asarray(camera.eye, dtype=np.float64)
    return View(eye, camera_axes(camera), tan_y * aspect, tan_y, float(camera.near), float(far))


def point_light(position: np.ndarray) -> np.ndarray:
    """A light at a place, as a homogeneous point float64 [4]."""
    return np.array([*position, 1.0])


def directional_light(direction: np.ndarray) -> np.ndarray:
    """A light infinitely far away in a direction, as a homogeneous point float64 [4]."""
    towards = np.asarray(direction, dtype=np.float64)
    length = np.linalg.norm(towards)
    if not 0 < length < math.inf:
        raise fail("the direction of a light must not be zero")
    return np.array([*(towards / length), 0.0])


def at_depth(view: View, x: np.ndarray, y: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """World points [..., 3] at image places x, y in [-1, 1] (right, up) and depths along the line of sight."""
    inside = np.stack(np.broadcast_arrays(view.tan_x * x * depth, view.tan_y * y * depth, depth), axis=-1)
    return np.asarray(view.eye + inside @ view.axes)


def corners(view: View, near: float, far: float) -> np.ndarray:
    """The eight corners of the part of a view between two depths, float64 [8, 3]."""
    x, y, depth = np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [near, far], indexing="ij")
    return at_depth(view, x.ravel(), y.ravel(), depth.ravel())


def volume_samples(view: View, num_across: int = 13, num_along: int = 49) -> np.ndarray:
    """Points [n, 3] all over a view, its surface included; evenly in the logarithm of depth."""
    across = np.linspace(-1, 1, num_across)
    depth = np.geomspace(view.near, view.far, num_along)
    x, y, z = np.meshgrid(across, across, depth, indexing="ij")
    return at_depth(view, x.ravel(), y.ravel(), z.ravel())


def depth_of(view: View, points: np.ndarray) -> np.ndarray:
    """Depth along the line of sight of world points [n, 3]."""
    return np.asarray((points - view.eye) @ view.axes[2])


def holds(view: View, point: np.ndarray) -> bool:
    """Whether a world point [3] is in a view or, to rounding, on what bounds it."""
    x, y, depth = view.axes @ (point - view.eye)
    slack = _SLACK * view.far
    beyond = [view.near - depth, depth - view.far, abs(x) - view.tan_x * depth, abs(y) - view.tan_y * depth]
    return bool(max(beyond) <= slack)


def pixel_size(view: View, points: np.ndarray, rows: int) -> np.ndarray:
    """World size of a pixel of an image of `rows` rows at points [n, 3]."""
    return depth_of(view, points) * 2 * view.tan_y / rows
