"""Views of shadow volumes for the tests."""

import numpy as np

from archsim.raster.eye_view import eye_view
from archsim.scene.camera import Camera
from archsim.scene.mesh import Mesh
from archsim.scene.scene import Light, Scene
from archsim.shadow import ray_trace
from archsim.shadow_volumes.casters import Grouping
from archsim.shadow_volumes.comparison import COMBINED, VARIANTS, Method, draw, prepare
from archsim.shadow_volumes.hierarchical import Resources
from archsim.shadow_volumes.psv_cache import CacheShape
from archsim.shadow_volumes.volumes import Counting, Extrusion

RESOURCES = Resources(num_psv_buffers=2, psv_cache=CacheShape(128, 32, 2), delay_stream_bytes=1 << 20)


def method(grouping=Grouping.OBJECTS, counting=Counting.Z_FAIL, reach=None, tile=8, resources=RESOURCES):
    return Method(Extrusion(grouping, counting, reach), tile, resources)


def prepared(scene, chosen=None):
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    return prepare(scene, scene.lights[0].position, seen, chosen or method())


def all_masks(scene, chosen=None):
    """Shadow masks of every variant."""
    chosen = chosen or method()
    view = prepared(scene, chosen)
    return {name: draw(view, name, chosen.resources).shadow for name in (*VARIANTS, COMBINED)}


def traced(scene):
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    return ray_trace.shadow_mask(scene, 0, seen)


def make_scene(vertices, triangles, eye, target, light, size=(64, 48), near=0.1, up=(0, 0, 1), objects=None):
    mesh = Mesh(np.array(vertices, np.float32), np.array(triangles, np.int32), objects)
    camera = Camera(np.array(eye, float), np.array(target, float), np.array(up, float), 60.0, near)
    return Scene(mesh, camera, (Light(np.array(light, float), None),), *size, "test")


def floor_and(vertices, triangles, half=50.0):
    """Those triangles as object 0 above a floor in z = 0 that casts no shadow."""
    floor = [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]
    corners = np.array(triangles) + 4
    objects = np.array([-1, -1] + [0] * len(corners), np.int32)
    return floor + list(vertices), [(0, 1, 2), (0, 2, 3), *map(tuple, corners)], objects


BOX = [(x, y, z) for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
BOX_TRIANGLES = [
    corners
    for a, b, c, d in (
        (0, 4, 6, 2),
        (1, 3, 7, 5),
        (0, 1, 5, 4),
        (2, 6, 7, 3),
        (0, 2, 3, 1),
        (4, 5, 7, 6),
    )
    for corners in ((a, b, c), (a, c, d))
]  # seen from outside counterclockwise
