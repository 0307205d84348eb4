"""Scenes: cameras and lights that span a view, and meshes that exist."""

from __future__ import annotations

from pathlib import Path

import pytest

from archsim import resources
from archsim.config import load_run, load_scene
from archsim.config.scene import GeneratorConfig

TINY = "scenes/tiny.yaml"


@pytest.mark.parametrize(
    ("override", "path", "message"),
    [
        ("camera.target=[0, -2.6, 1.8]", "camera.target", "must not be the same point as eye"),
        ("camera.up=[0,0,0]", "camera.up", "must not be zero"),
        ("camera.up=[0, -2.6, 1.8]", "camera.up", "must not be parallel to the view direction"),
        ("camera.up=[0, 5.2, -3.6]", "camera.up", "must not be parallel to the view direction"),
        ("camera.fovy_degrees=0.5", "camera.fovy_degrees", "must be at least 1, not 0.5"),
        ("camera.near=-1", "camera.near", "must be above 0, not -1"),
        ("camera.near=.inf", "camera.near", "must be a finite number, not inf"),
        ("resolution=[64, 8193]", "resolution.1", "must be at most 8192, not 8193"),
        ("resolution=[64, 64.0]", "resolution.1", "must be a whole number, not 64.0"),
        ("resolution=[64]", "resolution", "too short a list"),
        (
            "mesh={generator: knots}",
            "mesh.generator",
            "must be amphitheater, knights, knot_and_spheres, power_plant, quad_and_triangle, robots, "
            "simple_occluder or town, not 'knots'; did you mean 'knights'?",
        ),
        ("mesh.seed=-1", "mesh.seed", "must be at least 0, not -1"),
        ("mesh.parameters={a: true}", "mesh.parameters.a", "must be a number, not true"),
        ("mesh.parameters={a: .nan}", "mesh.parameters.a", "must be a number between -1e12 and 1e12"),
    ],
)
def test_what_spans_no_view_is_said(problems, override, path, message):
    assert problems(load_scene, TINY, [override]) == [f"--set {override}: {path}: {message}"]


@pytest.mark.parametrize(
    ("view", "path", "message"),
    [
        (
            "{target: [1, 2, 3], up: [0, 0, 1], fovy_degrees: 90}",
            "target",
            "must not be the same point as position",
        ),
        (
            "{target: [1, 2, 0], up: [0, 0, 2], fovy_degrees: 90}",
            "up",
            "must not be parallel to the view direction",
        ),
        (
            "{target: [1, 2, 0], up: [0, 1, 0], fovy_degrees: 171}",
            "fovy_degrees",
            "must be at most 170, not 171",
        ),
    ],
)
def test_a_light_s_view_is_checked_like_a_camera(problems, view, path, message):
    override = f"lights=[{{position: [1, 2, 3], view: {view}}}]"
    assert problems(load_scene, TINY, [override]) == [f"--set {override}: lights.0.view.{path}: {message}"]


def test_a_light_has_no_view_unless_it_says_so():
    assert load_scene(TINY).lights[0].view is None
    view = load_scene(TINY, ["lights.0.view={target: [0,0,0], up: [0,1,0], fovy_degrees: 90}"]).lights[0].view
    assert view.target == (0, 0, 0)


def test_generator_parameters_stay_the_numbers_they_are():
    scene = load_scene(TINY, ["mesh={generator: knot_and_spheres, parameters: {a: 3, b: 0.5}}"])
    assert scene.mesh == GeneratorConfig(generator="knot_and_spheres", parameters={"a": 3, "b": 0.5})
    assert type(scene.mesh.parameters["a"]) is int


def test_a_generator_merges_key_by_key_and_is_replaced_as_a_whole():
    merged = load_scene(TINY, ["mesh.seed=7", "mesh.generator=knot_and_spheres"]).mesh
    assert merged == GeneratorConfig(generator="knot_and_spheres", seed=7)
    assert load_scene(TINY, ["mesh.seed=7", "mesh={generator: quad_and_triangle}"]).mesh.seed == 0
    assert load_scene(TINY, ["mesh=nx_aggressor_7k5"]).mesh == "nx_aggressor_7k5"
    assert load_scene(TINY, ["mesh=nx_aggressor_7k5", "mesh.generator=quad_and_triangle"]).mesh.seed == 0


def test_a_mesh_s_path_is_relative_to_the_file_that_says_it(write):
    write("folder/meshes/cube.npz", "")
    write("folder/scene.yaml", "base: scenes/tiny.yaml\nmesh: meshes/cube.npz")
    write("run.yaml", "base: runs/tiny.yaml\nscene: folder/scene.yaml")
    absolute = str(Path.cwd() / "folder/meshes/cube.npz")
    assert load_scene("folder/scene.yaml").mesh == absolute
    assert load_run("run.yaml").scene.mesh == absolute


def test_a_mesh_s_path_in_an_override_is_relative_to_the_current_folder(write):
    write("cube.PLY", "")
    assert load_run("runs/tiny.yaml", ["scene.mesh=cube.PLY"]).scene.mesh == str(Path.cwd() / "cube.PLY")
    absolute = str(Path.cwd() / "cube.PLY")
    assert load_run("runs/tiny.yaml", [f"scene.mesh={absolute}"]).scene.mesh == absolute


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        ("cub.npz", "no such mesh file: 'cub.npz'; did you mean 'cube.npz'?"),
        ("meshes/cube.npz", "no such mesh file: 'meshes/cube.npz'"),
        (
            "folder/",
            f"no packaged mesh is named 'folder/'; packaged meshes are {', '.join(resources.mesh_names())}",
        ),
        ("cube.fbx", "'cube.fbx' is not a mesh file of a known type (.npz, .ply, .obj, .stl, .glb)"),
        ("nx_agressor_7k5", "no packaged mesh is named 'nx_agressor_7k5'; did you mean 'nx_aggressor_7k5'?"),
    ],
)
def test_meshes_that_do_not_exist(write, problems, mesh, message):
    write("cube.npz", "")
    write("folder/x", "")
    assert problems(load_scene, TINY, [f"mesh={mesh}"]) == [f"--set mesh={mesh}: {message}"]
