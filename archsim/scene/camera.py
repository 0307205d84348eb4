"""The pinhole camera: view axes and the rays through pixel centres.

The world is right-handed. Row 0 of an image is its top. Depth z is the distance along the forward axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from archsim.errors import fail


class Camera(NamedTuple):
    """Where one looks from, and how wide."""

    eye: np.ndarray  # float64 [3]
    target: np.ndarray  # float64 [3] a point in the middle of the image
    up: np.ndarray  # float64 [3] points to the top of the image; any length, not along the line of sight
    fovy_degrees: float  # full vertical field of view, between 0 and 180
    near: float  # geometry with z < near is not seen


class PixelRays(NamedTuple):
    """World-space rays: through the centre of pixel (x, y) goes the direction corner + x step_x + y step_y.

    Every direction advances by 1 along the forward axis, so the point at depth z is origin + z direction.
    """

    origin: np.ndarray  # float64 [3]
    corner: np.ndarray  # float64 [3] direction through the centre of pixel (0, 0)
    step_x: np.ndarray  # float64 [3] per column to the right
    step_y: np.ndarray  # float64 [3] per row down


class ViewWindow(NamedTuple):
    """The same in view space: direction (left + x step_x, top + y step_y, 1) along right, up, forward."""

    left: float
    top: float
    step_x: float
    step_y: float  # negative: rows go down, the up axis goes up
    width: int  # columns
    height: int  # rows
    near: float


def camera_axes(camera: Camera) -> np.ndarray:
    """Orthonormal rows right, up, forward; float64 [3, 3]. Raises ArchsimError if the camera has none."""
    line_of_sight = np.subtract(camera.target, camera.eye, dtype=np.float64)
    forward = _unit(line_of_sight, "camera: eye and target are the same point")
    up = _unit(np.asarray(camera.up, dtype=np.float64), "camera: up is zero")
    right = np.cross(forward, up)
    if np.linalg.norm(right) < 1e-9:
        raise fail("camera: up points along the line of sight")
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward])


def view_window(camera: Camera, width: int, height: int) -> ViewWindow:
    """The rays of an image of `width` x `height` pixels in view space; pixels are square."""
    if not (camera.near > 0 and 0 < camera.fovy_degrees < 180):
        raise fail(
            f"camera: near must be > 0 and fovy in (0, 180); they are {camera.near}, {camera.fovy_degrees}"
        )
    half_height = math.tan(math.radians(camera.fovy_degrees) / 2)
    half_width = half_height * width / height
    left = half_width * (1 / width - 1)
    top = half_height * (1 - 1 / height)
    return ViewWindow(
        left, top, 2 * half_width / width, -2 * half_height / height, width, height, float(camera.near)
    )


def pixel_rays(camera: Camera, width: int, height: int) -> PixelRays:
    """The rays of an image of `width` x `height` pixels in world space."""
    right, up, forward = camera_axes(camera)
    window = view_window(camera, width, height)
    return PixelRays(
        origin=np.asarray(camera.eye, dtype=np.float64),
        corner=window.left * right + window.top * up + forward,
        step_x=window.step_x * right,
        step_y=window.step_y * up,
    )


def to_view_space(points: np.ndarray, camera: Camera) -> np.ndarray:
    """Points [n, 3] along the camera's right, up and forward axes, from its eye; float64 [n, 3].

    Written out rather than as a matrix product, so that equal points stay equal wherever they stand.
    """
    x, y, z = (np.asarray(points, dtype=np.float64) - np.asarray(camera.eye, dtype=np.float64)).T
    return np.stack([x * axis[0] + y * axis[1] + z * axis[2] for axis in camera_axes(camera)], axis=1)


def _unit(vector: np.ndarray, problem: str) -> np.ndarray:
    """The vector at length 1; scaled first, so that neither tiny nor huge vectors are lost."""
    largest = np.abs(vector).max()
    if not 0 < largest < np.inf:
        raise fail(problem)
    scaled = vector / largest
    return np.asarray(scaled / np.linalg.norm(scaled))
