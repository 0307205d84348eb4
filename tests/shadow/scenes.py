"""Small random scenes for the tests."""

import numpy as np

from archsim.scene.camera import Camera
from archsim.scene.mesh import Mesh
from archsim.scene.scene import Light, Scene


def soup(seed, num_triangles=12, size=(24, 16)):
    """Random triangles in front of, around and behind a camera and a light that stand among them."""
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-3, 3, (num_triangles, 1, 3))
    corners = (centres + rng.normal(0, 1.5, (num_triangles, 3, 3))).astype(np.float32)
    mesh = Mesh(corners.reshape(-1, 3), np.arange(3 * num_triangles, dtype=np.int32).reshape(-1, 3))
    eye = rng.uniform(-4, 4, 3)
    camera = Camera(eye, eye + rng.normal(0, 1, 3), np.array([0.0, 0.3, 1.0]), rng.uniform(30, 110), 0.05)
    return Scene(mesh, camera, (Light(rng.uniform(-4, 4, 3), None),), *size, f"soup {seed}")


def facing_quad(light, view=None, size=(32, 32)):
    """A 2 x 2 square in z = 0 seen from straight above, with a light."""
    vertices = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    mesh = Mesh(vertices, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    camera = Camera(np.array([0.0, 0, 2]), np.zeros(3), np.array([0.0, 1, 0]), 50.0, 0.1)
    return Scene(mesh, camera, (Light(np.array(light, dtype=float), view),), *size, "quad")
