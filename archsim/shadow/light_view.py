"""Light views: which samples a light sees through which perspective view, and each view's map to logical cells.

One view is enough when the samples fit it; else up to six views along the axes of a cube share them, so that no
sample is ever left out. A view is a linear map of light-relative world space to homogeneous logical coordinates
(X, Y, W): the logical position is (X / W, Y / W), the light depth is W. Samples and occluders are compared by
depth = 1 - nearest / W, with `nearest` the light depth of the nearest sample: it grows with the distance from the
light, is linear over a triangle, and keeps its precision however far away the light is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.raster.eye_view import EyeView
from archsim.scene.camera import pixel_rays
from archsim.scene.scene import Light, Scene
from archsim.shadow.grid import Grid

MAX_HALF_ANGLE_DEGREES = 60.0  # a fitted view wider than this gives way to a cube's faces
MARGIN_CELLS = 0.05  # samples stay at least this far inside the grid
AT_LIGHT = (
    2.0**-14
)  # a sample this near to the light, relative to the way eye - sample - light, counts as lit
ROUNDING = 2.0**-21  # float32 error of the sums that give a sample's place, relative to their largest term
MOST_ROUNDING = 2.0**-14  # of a depth: samples right at the light do not set the offset of all others
NARROWEST = 2.0**12  # a window is at least this many rounding errors wide


class LightFace(NamedTuple):
    """One perspective view from the light and the samples that it takes."""

    to_logical: np.ndarray  # float64 [3, 3]: (X, Y, W) = to_logical @ (world - light)
    light: np.ndarray  # float64 [3]
    taken: np.ndarray  # bool [height, width]: pixels whose samples belong to this face
    nearest: float  # light depth of the nearest sample
    rounding_cells: float  # float32 error of a sample's logical position
    rounding_depth: float  # float32 error of a sample's depth, 1 - nearest / light depth


def sample_points(scene: Scene, eye_view: EyeView) -> np.ndarray:
    """World positions float64 [height, width, 3] of what the pixels show; NaN where they show nothing."""
    origin, corner, step_x, step_y = pixel_rays(scene.camera, scene.width, scene.height)
    x = np.arange(scene.width)[None, :, None]
    y = np.arange(scene.height)[:, None, None]
    depth = 1.0 / eye_view.reciprocal_depth.astype(np.float64)[..., None]
    return origin + depth * (corner + x * step_x + y * step_y)


class _Samples(NamedTuple):
    """What the views share out."""

    towards: np.ndarray  # float64 [height, width, 3] from the light to the sample
    reach: np.ndarray  # float64 [height, width] distance from the eye
    eye: np.ndarray  # float64 [3] from the light to the eye
    sampled: np.ndarray  # bool [height, width]


def light_faces(scene: Scene, eye_view: EyeView, light: Light, grid: Grid) -> list[LightFace]:
    """The views that together take every sample, each fitted to the grid; none when there is no sample."""
    position = np.asarray(light.position, dtype=np.float64)
    samples = _samples(scene, eye_view, position)
    towards = samples.towards[samples.sampled]
    if not len(towards):
        return []
    if light.view is not None:
        axes = _axes(np.asarray(light.view.target) - position, np.asarray(light.view.up, dtype=np.float64))
        half = float(np.tan(np.radians(light.view.fovy_degrees) / 2))
        if _fits(towards @ axes.T, half):
            return [_face(axes, grid, position, samples, samples.sampled, (-half, -half, half, half))]
    else:
        axes = _middle_axes(towards)
        if _fits(towards @ axes.T, float(np.tan(np.radians(MAX_HALF_ANGLE_DEGREES)))):
            return [_face(axes, grid, position, samples, samples.sampled)]
    return [_face(face, grid, position, samples, taken) for face, taken in _cube(axes, samples)]


def _samples(scene: Scene, eye_view: EyeView, position: np.ndarray) -> _Samples:
    """Samples relative to a light at `position`; those at the light itself are left out."""
    points = sample_points(scene, eye_view)
    eye = np.asarray(scene.camera.eye, dtype=np.float64)
    reach = np.linalg.norm(points - eye, axis=-1)
    towards = points - position
    way = reach + np.linalg.norm(eye - position)
    sampled = np.linalg.norm(towards, axis=-1) > AT_LIGHT * way  # False where NaN
    return _Samples(towards, reach, eye - position, sampled)


def _axes(forward: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Rows right, down, forward of an orthonormal frame that looks along `forward`."""
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def _middle_axes(directions: np.ndarray) -> np.ndarray:
    """Axes that look at the middle of the directions, with the world axis least along it as up."""
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    middle = (directions / np.where(lengths > 0, lengths, 1.0)).mean(axis=0)
    if np.linalg.norm(middle) < 1e-6:
        middle = np.array([0.0, 0.0, -1.0])
    up = np.zeros(3)
    up[np.argmin(np.abs(middle))] = 1.0
    return _axes(middle, up)


def _fits(local: np.ndarray, half: float) -> bool:
    """Whether all points, in a frame's coordinates, lie inside its square frustum."""
    inside = np.abs(local[:, :2]).max(axis=1) <= half * local[:, 2]
    return bool((inside & (local[:, 2] > 0)).all())


def _cube(axes: np.ndarray, samples: _Samples) -> list[tuple[np.ndarray, np.ndarray]]:
    """(axes, pixels taken) of the populated faces of a cube around the light; each sample goes to one face."""
    local = np.where(samples.sampled[..., None], samples.towards @ axes.T, 0.0)
    main = np.argmax(np.abs(local), axis=-1)
    along = np.take_along_axis(local, main[..., None], axis=-1)[..., 0]
    faces = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            taken = samples.sampled & (main == axis) & (along * sign > 0)
            if taken.any():
                faces.append((_axes(sign * axes[axis], axes[(axis + 1) % 3]), taken))
    return faces


def _face(
    axes: np.ndarray,
    grid: Grid,
    position: np.ndarray,
    samples: _Samples,
    taken: np.ndarray,
    window: tuple[float, float, float, float] | None = None,
) -> LightFace:
    """The face that looks along `axes`, with a window (x0, y0, x1, y1) on the tangent plane, by default a tight one."""
    local, reach, eye = samples.towards[taken] @ axes.T, samples.reach[taken], axes @ samples.eye
    depth = local[:, 2]
    if window is None:
        x, y = local[:, 0] / depth, local[:, 1] / depth
        window = (x.min(), y.min(), x.max(), y.max())

    def rounding(constant: float, scaled: np.ndarray | float) -> float:
        """Error of (numerator / W): the numerator's terms, and those of W times how far the quotient is from 0."""
        return ROUNDING * float(((reach + abs(constant) + (reach + abs(eye[2])) * scaled) / depth).max())

    error_x = rounding(eye[0] - window[0] * eye[2], window[2] - window[0])
    error_y = rounding(eye[1] - window[1] * eye[2], window[3] - window[1])
    scale_x, shift_x = _fit(grid.logical_width, window[0], window[2], error_x)
    scale_y, shift_y = _fit(grid.logical_height, window[1], window[3], error_y)
    to_cells = np.array([[scale_x, 0.0, shift_x], [0.0, scale_y, shift_y], [0.0, 0.0, 1.0]])
    nearest = float(depth.min())
    return LightFace(
        to_logical=to_cells @ axes,
        light=position,
        taken=taken,
        nearest=nearest,
        rounding_cells=max(scale_x * error_x, scale_y * error_y),
        rounding_depth=min(rounding(eye[2] - nearest, 1.0 - nearest / depth), MOST_ROUNDING),
    )


def _fit(num_cells: int, low: float, high: float, error: float) -> tuple[float, float]:
    """Scale and shift that put low ... high onto the cells, less a margin that keeps a rounding `error` inside.

    A window too small for float32 is widened.
    """
    middle, extent = 0.5 * (low + high), max(high - low, error * NARROWEST) + 2 * error
    scale = (num_cells - 2 * MARGIN_CELLS) / extent
    return scale, 0.5 * num_cells - scale * middle
