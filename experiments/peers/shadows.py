"""Shadow masks beside those of Embree, a ray tracer that is not ours, in random views of any mesh.

Install: pip install embreex
Run:     python experiments/peers/shadows.py MESH ... [--views 4] [--seed 1]

MESH is a path of an .npz file (v: vertices, f: triangles) or the name of a packaged mesh. Views and lights are drawn
until Embree finds 15 to 85 % of a picture without background in shadow. Nothing of archsim's cameras, rays or
intersections is used here: the picture is what the scene's YAML keys say. A pixel is at an edge if its neighbours do
not all show the same triangle in the same light.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

import archsim
from archsim import resources

WIDTH, HEIGHT, NEAR = 320, 256, 1.0
RUNS = {
    "irregular z-buffer": ("izb_bloodprison_light0", {}),
    "shadow volumes": ("hsv_knights_hierarchical", {"workload.range": None}),
}
CONTACT = 1e-3  # of the way from the light to a point: what is nearer to the point does not shade it


class Traced:
    """A mesh that Embree can see."""

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray):
        self.corners = vertices[triangles].astype(np.float64)  # [num_triangles, 3, 3]
        self.scene = EmbreeScene(robust=True)
        TriangleMesh(self.scene, self.corners.astype(np.float32))
        first, second = self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]
        self.normals = np.cross(first, second)

    def first_hits(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangle (or -1) and distance, in units of the direction, that each ray meets first."""
        rays = [np.ascontiguousarray(part, np.float32) for part in np.broadcast_arrays(origins, directions)]
        found = self.scene.run(*rays, output=1)
        return found["primID"], found["tfar"]

    def picture(self, camera: dict[str, Any], light: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangle seen in each pixel, and whether it is in shadow there; both [HEIGHT, WIDTH]."""
        eye, directions = np.array(camera["eye"]), directions_of(camera)
        start = eye + NEAR * directions
        seen, distance = self.first_hits(start, directions)
        points = start + distance[:, None] * directions
        blocker, nearness = self.first_hits(light, points - light)
        normals = self.normals[seen]
        to_eye, to_light = ((normals * (place - points)).sum(axis=1) for place in (eye, light))
        is_behind = to_eye * to_light < 0  # the light falls on the other side
        is_dark = (seen >= 0) & (is_behind | ((blocker >= 0) & (nearness < 1 - CONTACT)))
        return seen.reshape(HEIGHT, WIDTH), is_dark.reshape(HEIGHT, WIDTH)


def directions_of(camera: dict[str, Any]) -> np.ndarray:
    """[HEIGHT * WIDTH, 3] rays through the pixel centres, row 0 at the top, of length 1 along the line of sight."""
    forward = np.subtract(camera["target"], camera["eye"])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera["up"])
    right /= np.linalg.norm(right)
    half_height = np.tan(np.radians(camera["fovy_degrees"]) / 2)
    x = (2 * (np.arange(WIDTH) + 0.5) / WIDTH - 1) * half_height * WIDTH / HEIGHT
    y = (1 - 2 * (np.arange(HEIGHT) + 0.5) / HEIGHT) * half_height
    grid = forward + y[:, None, None] * np.cross(right, forward) + x[None, :, None] * right
    return grid.reshape(-1, 3)


def views(
    traced: Traced, rng: np.random.Generator
) -> Iterator[tuple[dict[str, Any], np.ndarray, np.ndarray]]:
    """Cameras and lights within the mesh's box, with Embree's shadow mask and the pixels at edges."""
    low, high = traced.corners.min(axis=(0, 1)), traced.corners.max(axis=(0, 1))
    while True:
        eye, target, light = np.round(rng.uniform(low, high, (3, 3)), 3).tolist()
        camera = {"eye": eye, "target": target, "up": [0, 0, 1], "near": NEAR}
        camera["fovy_degrees"] = float(rng.integers(40, 100))
        seen, is_dark = traced.picture(camera, np.array(light))
        if (seen >= 0).all() and 0.15 < is_dark.mean() < 0.85:
            yield (
                {"scene.camera": camera, "scene.lights": [{"position": light}]},
                is_dark,
                edges(seen, is_dark),
            )


def edges(*pictures: np.ndarray) -> np.ndarray:
    """Pixels with a neighbour, or itself at the picture's border, that differs in one of the pictures."""
    found = np.zeros((HEIGHT, WIDTH), bool)
    for picture in pictures:
        padded = np.pad(picture, 1, mode="edge")
        for row in range(3):
            for column in range(3):
                found |= padded[row : row + HEIGHT, column : column + WIDTH] != picture
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--views", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(
        "| mesh | algorithm | in shadow | pixels that differ | of them not at an edge |\n|---|---|---|---|---|"
    )
    for mesh in options.meshes:
        path = Path(mesh) if Path(mesh).exists() else resources.mesh(mesh)
        arrays = np.load(path)
        found = views(Traced(arrays["v"], arrays["f"]), np.random.default_rng(options.seed))
        for (scene, expected, at_edge), _ in zip(found, range(options.views), strict=False):
            for algorithm, (run, changes) in RUNS.items():
                scene |= {"scene.mesh": mesh, "scene.resolution": [WIDTH, HEIGHT]}
                wrong = archsim.simulate(run, {**scene, **changes}).result.shadow != expected
                row = [path.stem, algorithm, f"{100 * expected.mean():.1f} %"]
                print(
                    "|", " | ".join([*row, str(wrong.sum()), str((wrong & ~at_edge).sum())]), "|", flush=True
                )


if __name__ == "__main__":
    main()
