"""A picture in shades of grey, and how far two pictures are apart."""

from __future__ import annotations

import numpy as np

from archsim.raster.eye_view import EyeView
from archsim.scene.scene import Scene
from archsim.shadow.light_view import sample_points


def unshadowed(scene: Scene, seen: EyeView, light: int) -> np.ndarray:
    """float64 [height, width]: cosine between the light's direction and the normal on the eye's side, 0 from behind."""
    points = sample_points(scene, seen)
    corners = scene.mesh.vertices.astype(np.float64)[scene.mesh.triangles[np.maximum(seen.triangle, 0)]]
    normal = np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])
    to_eye = np.asarray(scene.camera.eye) - points
    to_light = np.asarray(scene.lights[light].position) - points
    normal = normal * np.where((normal * to_eye).sum(axis=-1, keepdims=True) < 0, -1.0, 1.0)
    lengths = np.linalg.norm(normal, axis=-1) * np.linalg.norm(to_light, axis=-1)
    cosine = (normal * to_light).sum(axis=-1) / np.where(lengths > 0, lengths, 1.0)
    return np.where(seen.triangle >= 0, np.maximum(cosine, 0.0), 0.0)


def l2_difference(image: np.ndarray, reference: np.ndarray) -> float:
    """Root of the mean squared difference of the pixels: the L2 norm of the difference over that of a white picture."""
    return float(np.sqrt(np.mean((image - reference) ** 2)))
