"""Solids that generators put together: closed, seen from outside counterclockwise, of the size asked for."""

import numpy as np
import pytest

from archsim.scene.generators import make_mesh
from archsim.scene.generators.shapes import (
    boxes,
    ground,
    join,
    sphere_triangles,
    spheres,
    tube_triangles,
    tubes,
)

BENT = np.array(
    [[(0.0, 0, 0), (0, 0, 2), (1, 0, 3), (3, 0, 3)], [(5.0, 0, 0), (5, 1, 0), (5, 2, 1), (5, 2, 3)]]
)
SOLIDS = {
    "boxes": boxes(np.array([(0, 0, 0), (2, 0, 0)]), np.array([(1, 2, 3), (3, 1, 1)])),
    "spheres": spheres(np.array([(0, 0, 0), (5, 0, 0)]), np.array([1.0, 2.0]), 48, 48),
    "tubes": tubes(BENT, np.array([0.2, 0.3]), 24),
}


def volume(mesh):
    """Of what is inside counterclockwise triangles."""
    a, b, c = (mesh.vertices[mesh.triangles[:, i]].astype(float) for i in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_closed(name):
    triangles = SOLIDS[name].triangles
    edges = {(int(t[i]), int(t[(i + 1) % 3])) for t in triangles for i in range(3)}
    assert len(edges) == 3 * len(triangles)
    assert all((b, a) in edges for a, b in edges)


def test_solids_have_the_volume_asked_for():
    assert volume(SOLIDS["boxes"]) == pytest.approx(6 + 1)
    assert volume(SOLIDS["spheres"]) == pytest.approx(4 / 3 * np.pi * 9, rel=0.01)
    lengths = np.linalg.norm(np.diff(BENT, axis=1), axis=-1).sum(axis=1)
    expected = (np.pi * np.array([0.2, 0.3]) ** 2 * lengths).sum()
    assert volume(SOLIDS["tubes"]) == pytest.approx(expected, rel=0.08)  # bends are a little thinner


def test_counts():
    assert len(SOLIDS["spheres"].triangles) == 2 * sphere_triangles(48, 48)
    assert len(SOLIDS["tubes"].triangles) == 2 * tube_triangles(4, 24)


def test_the_ground_is_seen_from_above():
    mesh = join([ground(1.0, 4, np.zeros((5, 5)))])
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert len(mesh.triangles) == 32


@pytest.mark.parametrize(
    ("name", "printed"), [("town", 58_000), ("robots", 95_000), ("power_plant", 1_700_000)]
)
def test_stand_ins_have_the_papers_number_of_triangles(name, printed):
    assert len(make_mesh(name, 0, {}).triangles) == pytest.approx(printed, rel=0.002)
