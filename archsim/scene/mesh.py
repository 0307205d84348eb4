"""Triangle meshes and how they are read: packaged by name, `.npz`, and by `mesh_files` the common formats."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from archsim import resources
from archsim.errors import ArchsimError, Location, did_you_mean, fail
from archsim.scene.mesh_files import MeshProblem, read_with_trimesh

FURTHEST = 1e9  # largest coordinate of a vertex; cameras and lights have the same limit


class Mesh(NamedTuple):
    """A triangle soup; triangles keep the order of their file and are seen from both sides."""

    vertices: np.ndarray  # float32 [num_vertices, 3] world coordinates
    triangles: np.ndarray  # int32 [num_triangles, 3] indices into vertices
    objects: np.ndarray | None = None  # int32 [num_triangles] whose shadow each is part of, -1: no shadow


SUFFIXES = (".npz", ".ply", ".obj", ".stl", ".glb")


def load_mesh(source: str, where: Location | None = None) -> Mesh:
    """The mesh `source`: the name of a packaged mesh, or the path of a file with one of SUFFIXES.

    Raises ArchsimError, at `where` when given, for anything that is not a usable mesh.
    """
    path = _find(source, where)
    try:
        if path.suffix.lower() == ".npz":
            vertices, triangles = _read_npz(path)
        else:
            vertices, triangles = read_with_trimesh(path)
        return checked_mesh(vertices, triangles)
    except MeshProblem as problem:
        raise fail(f"mesh '{path}': {problem}", where) from problem
    except OSError as problem:
        raise fail(f"mesh '{path}' cannot be read: {problem.strerror or problem}", where) from problem


def checked_mesh(vertices: np.ndarray, triangles: np.ndarray) -> Mesh:
    """A Mesh of these arrays, or MeshProblem saying what is wrong with them."""
    _check_array("vertices", vertices, "f")
    _check_array("triangles", triangles, "iu")
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = np.ascontiguousarray(vertices, dtype=np.float32)
    bad_vertices = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if bad_vertices.size:
        raise MeshProblem(f"vertex {bad_vertices[0]} is not finite (as float32)")
    far_vertices = np.flatnonzero(np.abs(vertices).max(axis=1, initial=0.0) > FURTHEST)
    if far_vertices.size:
        raise MeshProblem(f"vertex {far_vertices[0]} has a coordinate beyond {FURTHEST:g}")

    bad_triangles = np.flatnonzero(((triangles < 0) | (triangles >= len(vertices))).any(axis=1))
    if bad_triangles.size:
        first = bad_triangles[0]
        corners = ", ".join(str(index) for index in triangles[first])
        raise MeshProblem(
            f"triangle {first} has vertices ({corners}), but there are {len(vertices)} vertices"
        )
    return Mesh(vertices, np.ascontiguousarray(triangles, dtype=np.int32))


def _check_array(what: str, array: np.ndarray, kinds: str) -> None:
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshProblem(f"{what} must have shape [n, 3], not {list(array.shape)}")
    if array.dtype.kind not in kinds:
        wanted = "floating point" if kinds == "f" else "integer"
        raise MeshProblem(f"{what} must be {wanted}, not {array.dtype}")


def _find(source: str, where: Location | None) -> Path:
    """The file that `source` names."""
    if Path(source).name == source and not Path(source).suffix:
        return _find_packaged(source, where)
    path = Path(source)
    if path.suffix.lower() not in SUFFIXES:
        raise fail(
            f"mesh '{source}' has the unknown suffix '{path.suffix}'",
            where,
            f"known are {', '.join(SUFFIXES)}",
        )
    if not path.is_file():
        beside = [f.name for f in path.parent.iterdir()] if path.parent.is_dir() else []
        raise fail(f"there is no mesh file '{source}'", where, did_you_mean(path.name, beside))
    return path


def _find_packaged(name: str, where: Location | None) -> Path:
    names = resources.mesh_names()
    if name not in names:
        hint = did_you_mean(name, names) or f"packaged are {', '.join(names)}"
        raise fail(f"there is no packaged mesh '{name}'", where, hint)
    return resources.mesh(name)


def _read_npz(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Arrays `v` and `f` of an .npz file; other arrays are not looked at. Pickles are refused."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            missing = [key for key in ("v", "f") if key not in arrays]
            if missing:
                raise MeshProblem(f"no array '{missing[0]}'; it has {', '.join(sorted(arrays)) or 'none'}")
            return arrays["v"], arrays["f"]
    except (MeshProblem, ArchsimError, FileNotFoundError, PermissionError):
        raise
    except (ValueError, TypeError, AttributeError, EOFError, OSError, zipfile.BadZipFile) as problem:
        raise MeshProblem(f"not a readable .npz file ({problem})") from problem
