"""From configuration to scene, and the digest that tells scenes apart."""

from types import SimpleNamespace as Config

import numpy as np
import pytest

from archsim.errors import ArchsimError
from archsim.scene.scene import LightView, digest, load_scene


def config(**changes):
    camera = Config(eye=(0, -2, 1), target=(0, 0, 0), up=(0, 0, 1), fovy_degrees=60, near=0.1)
    view = Config(target=(0, 0, 0), up=(0, 1, 0), fovy_degrees=40)
    lights = (Config(position=(1, 1, 3), view=None), Config(position=(0, 0, 4), view=view))
    mesh = Config(generator="quad_and_triangle", seed=0, parameters={})
    values = {"name": "a", "mesh": mesh, "camera": camera, "lights": lights, "resolution": (8, 6)}
    return Config(**(values | changes))


def test_a_scene_holds_what_the_configuration_says():
    scene = load_scene(config())
    assert (scene.name, scene.width, scene.height, len(scene.mesh.triangles)) == ("a", 8, 6, 3)
    np.testing.assert_array_equal(scene.camera.eye, (0, -2, 1))
    assert (scene.camera.fovy_degrees, scene.camera.near) == (60.0, 0.1)
    assert scene.lights[0].view is None
    view = scene.lights[1].view
    assert isinstance(view, LightView)
    np.testing.assert_array_equal(view.up, (0, 1, 0))
    assert view.fovy_degrees == 40.0


def test_a_packaged_mesh_is_named_by_text():
    assert len(load_scene(config(mesh="nx_aggressor_7k5")).mesh.triangles) == 7481
    with pytest.raises(ArchsimError, match="did you mean 'nx_aggressor_7k5'"):
        load_scene(config(mesh="nx_agressor_7k5"))


def test_the_digest_is_stable_and_blind_to_the_name():
    assert digest(load_scene(config())) == digest(load_scene(config(name="b")))
    assert len(digest(load_scene(config()))) == 64


def changed(scene):
    """The scene with one thing changed, in every way that changes the picture."""
    mesh, camera, light = scene.mesh, scene.camera, scene.lights[1]
    moved = mesh.vertices.copy()
    moved[-1, 2] = np.nextafter(moved[-1, 2], np.float32(9))
    yield scene._replace(mesh=mesh._replace(vertices=moved))
    yield scene._replace(mesh=mesh._replace(triangles=mesh.triangles[::-1]))
    for field in ("eye", "target", "up"):
        yield scene._replace(camera=camera._replace(**{field: getattr(camera, field) + 1e-9}))
    yield scene._replace(camera=camera._replace(fovy_degrees=61.0))
    yield scene._replace(camera=camera._replace(near=0.2))
    yield scene._replace(lights=scene.lights[::-1])
    yield scene._replace(lights=scene.lights[:1])
    yield scene._replace(lights=())
    yield scene._replace(lights=(scene.lights[0], light._replace(position=light.position + 1)))
    yield scene._replace(lights=(scene.lights[0], light._replace(view=None)))
    yield scene._replace(
        lights=(scene.lights[0], light._replace(view=light.view._replace(fovy_degrees=41.0)))
    )
    yield scene._replace(width=6, height=8)


def test_the_digest_sees_every_change():
    scene = load_scene(config())
    digests = [digest(scene), *(digest(other) for other in changed(scene))]
    assert len(set(digests)) == len(digests)


def test_the_digest_does_not_depend_on_the_layout_in_memory():
    scene = load_scene(config())
    fortran = scene.mesh._replace(vertices=np.asfortranarray(scene.mesh.vertices))
    assert digest(scene._replace(mesh=fortran)) == digest(scene)
