"""Reading .ply, .obj, .stl and .glb with trimesh, which is only loaded when such a file is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

# Nothing is merged or reordered, an .obj is one mesh, and material files beside it are not looked at.
_READER_OPTIONS: dict[str, Any] = {
    "process": False,
    "maintain_order": True,
    "split_object": False,
    "group_material": False,
    "skip_materials": True,
}


class MeshProblem(Exception):
    """What is wrong with a mesh; `load_mesh` adds the file's name and the place that asked for it."""


def read_with_trimesh(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices float [n, 3] and triangles int [m, 3] of all meshes in the file, scene transforms applied.

    Nothing is merged, moved or dropped; polygons are cut into triangles.
    """
    import trimesh

    try:
        loaded = trimesh.load_scene(path, **_READER_OPTIONS)
        parts = loaded.dump() if loaded.geometry else []
    except Exception as problem:  # the readers raise whatever a damaged file makes them trip over
        raise MeshProblem(f"not a readable {path.suffix} file ({problem})") from problem

    meshes = [part for part in parts if isinstance(part, trimesh.Trimesh)]
    if not meshes:
        raise MeshProblem("it has no triangles")
    firsts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    vertices = np.concatenate([np.asarray(mesh.vertices, dtype=np.float64) for mesh in meshes])
    triangles = np.concatenate(
        [np.asarray(mesh.faces, dtype=np.int64) + first for mesh, first in zip(meshes, firsts, strict=True)]
    )
    return vertices, triangles
