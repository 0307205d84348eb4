"""Reading meshes: what is accepted keeps every triangle in place, what is not fails by name."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from archsim import resources
from archsim.errors import ArchsimError, Location
from archsim.scene.mesh import load_mesh

VERTICES = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0.25), (0, 1, 0), (0, 0, 1.5)], dtype=np.float32)
TRIANGLES = np.array([(3, 2, 0), (0, 1, 2), (4, 1, 0)], dtype=np.int32)


def save(path: Path, **arrays) -> str:
    np.savez(path, **arrays)
    return str(path)


def failure(source: object) -> str:
    with pytest.raises(ArchsimError) as caught:
        load_mesh(str(source), Location("scene.yaml", 3, 7))
    message = str(caught.value)
    assert message.startswith("scene.yaml:3:7: ")
    return message


@pytest.mark.parametrize(("name", "count"), [("nx_bloodprison_8k9", 8858), ("nx_aggressor_7k5", 7481)])
def test_packaged_meshes_load(name, count):
    mesh = load_mesh(name)
    assert mesh.triangles.shape == (count, 3)
    assert (mesh.vertices.dtype, mesh.triangles.dtype) == (np.float32, np.int32)


def test_every_packaged_mesh_has_its_licence_named():
    licences = (resources.mesh("x").parent / "LICENSES.md").read_text()
    assert all(f"`{name}.npz`" in licences for name in resources.mesh_names())


def test_npz_keeps_order_and_ignores_other_arrays(tmp_path):
    mesh = load_mesh(
        save(tmp_path / "a.npz", v=VERTICES.astype(np.float64), f=TRIANGLES.astype(np.uint64), x=[1])
    )
    np.testing.assert_array_equal(mesh.vertices, VERTICES)
    np.testing.assert_array_equal(mesh.triangles, TRIANGLES)
    assert (mesh.vertices.dtype, mesh.triangles.dtype) == (np.float32, np.int32)


def test_a_mesh_without_triangles_is_a_mesh(tmp_path):
    mesh = load_mesh(save(tmp_path / "a.npz", v=np.zeros((0, 3), np.float32), f=np.zeros((0, 3), np.int32)))
    assert len(mesh.triangles) == 0


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".glb"])
def test_formats_keep_every_triangle_in_place_and_order(tmp_path, suffix):
    path = tmp_path / f"mesh{suffix}"
    trimesh.Trimesh(VERTICES, TRIANGLES, process=False).export(path)
    mesh = load_mesh(str(path))
    np.testing.assert_array_equal(mesh.vertices[mesh.triangles], VERTICES[TRIANGLES])


def test_glb_applies_the_transforms_of_the_scene(tmp_path):
    part = trimesh.Trimesh(VERTICES, TRIANGLES, process=False)
    scene = trimesh.Scene()
    scene.add_geometry(part, transform=trimesh.transformations.translation_matrix((10, 0, 0)))
    scene.add_geometry(part, transform=trimesh.transformations.translation_matrix((0, 20, 0)))
    scene.export(tmp_path / "two.glb")
    mesh = load_mesh(str(tmp_path / "two.glb"))
    found = {tuple(corners.ravel()) for corners in mesh.vertices[mesh.triangles]}
    moved = [VERTICES[TRIANGLES] + np.float32(shift) for shift in ((10, 0, 0), (0, 20, 0))]
    assert found == {tuple(corners.ravel()) for part in moved for corners in part}


def test_obj_quads_are_cut_and_materials_not_looked_for(tmp_path):
    path = tmp_path / "quads.obj"
    path.write_text(
        "mtllib missing.mtl\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n"
        "o two\nv 0 0 5\nusemtl blue\nf 1 2 5\n"
    )
    mesh = load_mesh(str(path))
    corners = mesh.vertices[mesh.triangles].astype(np.float64)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert len(corners) == 3
    assert sorted(areas) == [0.5, 0.5, 2.5]


def test_unknown_names_say_what_was_meant(tmp_path):
    assert failure("nx_bloodprison").endswith("did you mean 'nx_bloodprison_8k9'?")
    assert "nx_aggressor_7k5" in failure("zzz")
    save(tmp_path / "castle.npz", v=VERTICES, f=TRIANGLES)
    assert "did you mean 'castle.npz'?" in failure(tmp_path / "casle.npz")
    assert "no mesh file" in failure(tmp_path / "nowhere" / "castle.npz")
    assert "unknown suffix '.dae'" in failure("castle.dae")
    assert "unknown suffix" in failure(tmp_path / "castle")
    assert "no packaged mesh ''" in failure("")


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"v": VERTICES}, "no array 'f'; it has v"),
        ({}, "no array 'v'"),
        ({"v": VERTICES[:, :2], "f": TRIANGLES}, "vertices must have shape [n, 3], not [5, 2]"),
        ({"v": VERTICES, "f": TRIANGLES.ravel()}, "triangles must have shape [n, 3], not [9]"),
        ({"v": VERTICES, "f": TRIANGLES.astype(np.float32)}, "triangles must be integer, not float32"),
        ({"v": VERTICES.astype(np.int64), "f": TRIANGLES}, "vertices must be floating point, not int64"),
        (
            {"v": VERTICES.astype(np.complex64), "f": TRIANGLES},
            "vertices must be floating point, not complex64",
        ),
        ({"v": VERTICES.astype(str), "f": TRIANGLES}, "vertices must be floating point"),
        ({"v": np.where(VERTICES > 1, np.nan, VERTICES), "f": TRIANGLES}, "vertex 4 is not finite"),
        ({"v": VERTICES * np.float64(1e300), "f": TRIANGLES}, "vertex 1 is not finite"),
        ({"v": VERTICES, "f": TRIANGLES + 1}, "triangle 2 has vertices (5, 2, 1), but there are 5 vertices"),
        ({"v": VERTICES, "f": TRIANGLES - 1}, "triangle 0 has vertices (2, 1, -1)"),
        ({"v": VERTICES, "f": TRIANGLES.astype(np.uint64) + np.uint64(2**63)}, "triangle 0 has vertices"),
        ({"v": VERTICES[:0], "f": TRIANGLES}, "but there are 0 vertices"),
    ],
)
def test_unusable_arrays_are_named(tmp_path, arrays, said):
    source = save(tmp_path / "bad.npz", **arrays)
    message = failure(source)
    assert source in message
    assert said in message


class Trap:
    """Unpickling it makes the file `sprung`."""

    def __init__(self, sprung: Path):
        self.sprung = sprung

    def __reduce__(self):
        return Path.touch, (self.sprung,)


def test_pickles_are_refused(tmp_path):
    objects = np.array([[Trap(tmp_path / "sprung")] * 3], dtype=object)
    np.savez(tmp_path / "evil.npz", v=objects, f=TRIANGLES)
    assert "not a readable .npz file" in failure(tmp_path / "evil.npz")
    (tmp_path / "pickle.npz").write_bytes(objects.dumps())
    assert "not a readable .npz file" in failure(tmp_path / "pickle.npz")
    assert not (tmp_path / "sprung").exists()


def test_a_plain_npy_file_is_not_an_npz(tmp_path):
    np.save(tmp_path / "a.npy", VERTICES)
    (tmp_path / "a.npy").rename(tmp_path / "a.npz")
    assert "not a readable .npz file" in failure(tmp_path / "a.npz")


@pytest.mark.parametrize("suffix", [".npz", ".ply", ".obj", ".stl", ".glb"])
@pytest.mark.parametrize(
    "content", [b"", b"once upon a time", b"PK\x03\x04", b"ply\n", b"glTF\0\0", bytes(100)]
)
def test_files_of_something_else_are_unreadable(tmp_path, suffix, content):
    path = tmp_path / f"other{suffix}"
    path.write_bytes(content)
    assert str(path) in failure(path)


@pytest.mark.parametrize("suffix", [".npz", ".ply", ".stl", ".glb"])
@pytest.mark.parametrize("kept", [0.3, 0.6, 0.95])
def test_truncated_files_are_unreadable(tmp_path, suffix, kept):
    path = tmp_path / f"cut{suffix}"
    if suffix == ".npz":
        save(path, v=VERTICES, f=TRIANGLES)
    else:
        trimesh.Trimesh(VERTICES, TRIANGLES, process=False).export(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(kept * len(whole))])
    assert str(path) in failure(path)


def test_damaged_bytes_inside_an_npz_are_noticed(tmp_path):
    path = tmp_path / "a.npz"
    np.savez_compressed(path, v=np.random.default_rng(1).random((500, 3)), f=TRIANGLES)
    whole = bytearray(path.read_bytes())
    whole[2000] ^= 0xFF
    path.write_bytes(whole)
    assert "not a readable .npz file" in failure(path)


def test_non_finite_numbers_in_other_formats_are_noticed(tmp_path):
    path = tmp_path / "nan.obj"
    path.write_text("v 0 0 0\nv 1 nan 0\nv 1 1 0\nf 1 2 3\n")
    assert "vertex 1 is not finite" in failure(path)


def test_a_folder_is_not_a_mesh(tmp_path):
    (tmp_path / "folder.npz").mkdir()
    assert "no mesh file" in failure(tmp_path / "folder.npz")
