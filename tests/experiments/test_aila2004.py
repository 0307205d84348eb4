"""The search of walkthroughs: eyes where people's would be, a part of the casters; and the files that came of it."""

import importlib.util
import sys

import numpy as np
import pytest

from archsim import resources
from archsim.config import load_walkthrough
from archsim.run.walkthrough import scene_at
from archsim.scene.generators import make_mesh
from archsim.shadow_volumes.casters import Grouping

FOLDER = resources.experiment("aila2004")
SEATED, STANDING = 1.2, 2.0  # eyes above what one sits or stands on


@pytest.fixture(scope="module")
def calibrate():
    spec = importlib.util.spec_from_file_location("calibrate_aila2004", FOLDER / "calibrate.py")
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        patch.delitem(sys.modules, "plant", raising=False)
        spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def plant(calibrate):
    return calibrate.plant


def test_steps_are_where_the_amphitheater_has_them(calibrate):
    config = load_walkthrough(FOLDER / "amphitheater.yaml")
    parameters = dict(config.scene.mesh.parameters)
    stage, steps = parameters["stage_radius"], calibrate.Steps()
    mesh = make_mesh("amphitheater", 0, parameters)
    receiving = mesh.vertices[np.unique(mesh.triangles[mesh.objects < 0])]
    on_axis = receiving[np.isclose(receiving[:, 0], 0, atol=1e-3) & (receiving[:, 1] > 1)]
    assert on_axis[:, 1].max() == pytest.approx(stage + steps.rows * steps.depth)
    for row in range(steps.rows):
        near, far = stage + row * steps.depth, stage + (row + 1) * steps.depth
        tread = on_axis[np.isclose(on_axis[:, 1], far, atol=1e-3), 2].min()
        assert calibrate.step_below(0.5 * (near + far) - stage, 90.0, steps) == pytest.approx(tread)


@pytest.mark.parametrize(("beyond", "azimuth"), [(-0.1, 90.0), (3.0, -90.0)])
def test_stage_and_open_side_have_no_steps(calibrate, beyond, azimuth):
    assert calibrate.step_below(beyond, azimuth, calibrate.Steps()) == 0.0


def test_the_amphitheaters_eye_is_someones_in_it(calibrate):
    config, steps = load_walkthrough(FOLDER / "amphitheater.yaml"), calibrate.Steps()
    stage = config.scene.mesh.parameters["stage_radius"]
    for frame in config.keyframes:
        x, y, z = frame.eye
        distance = np.hypot(x, y)
        assert distance < stage + steps.rows * steps.depth
        below = calibrate.step_below(distance - stage, np.degrees(np.arctan2(y, x)), steps)
        assert SEATED <= z - below <= STANDING
    assert np.hypot(*config.scene.lights[0].position[:2]) <= stage


def test_the_amphitheaters_eye_keeps_an_arms_length_from_columns_and_actors(calibrate):
    config = load_walkthrough(FOLDER / "amphitheater.yaml")
    mesh = make_mesh("amphitheater", 0, dict(config.scene.mesh.parameters))
    columns = mesh.vertices[np.unique(mesh.triangles[mesh.objects == 0])]
    assert calibrate.clearance(config) >= calibrate.ARMS_LENGTH
    for number in range(config.frames):
        eye = scene_at(config, number / (config.frames - 1)).camera.eye
        assert np.linalg.norm(columns[:, :2] - eye[:2], axis=1).min() >= calibrate.ARMS_LENGTH


@pytest.mark.parametrize(
    ("start", "end", "nearest"),
    [
        ("[0, -9, 1.5]", "[0, -4, 1.5]", 2.75),  # the middle column's axis is at (0, -1), its radius 0.25
        ("[-1, -1.5, 1.5]", "[1, -1.5, 1.5]", 0.25),  # past it between two keyframes
        ("[6.01, 2, 1.5]", "[6.01, 0.4, 1.5]", 0.4),  # the actor is at (6.01, 0)
    ],
)
def test_clearance_is_the_least_on_the_way(calibrate, start, end, nearest):
    mesh = (
        "{generator: amphitheater, parameters: {actors: 1, columns: 3, column_height: 5, stage_radius: 10}}"
    )
    keyframes = f"[{{eye: {start}}}, {{eye: {end}}}]"
    overrides = [f"scene.mesh={mesh}", f"keyframes={keyframes}"]
    config = load_walkthrough(FOLDER / "amphitheater.yaml", overrides)
    assert calibrate.clearance(config) == pytest.approx(nearest, abs=1e-3)


def test_the_knights_are_seen_by_one_of_them():
    frames = load_walkthrough(FOLDER / "knights.yaml").keyframes
    assert all(1.5 <= frame.eye[2] <= STANDING for frame in frames)
    assert all(np.hypot(*frame.eye[:2]) >= 3.0 for frame in frames)


@pytest.mark.parametrize("name", ["powerplant_lamp", "powerplant_sun"])
def test_someone_walks_in_the_power_plant(plant, name):
    config = load_walkthrough(FOLDER / f"{name}.yaml")
    parameters = dict(config.scene.mesh.parameters)
    assert plant.keeps_rules(config, make_mesh("power_plant", 0, parameters))
    eyes, lights = (
        np.array([getattr(frame, each) for frame in config.keyframes]) for each in ("eye", "light")
    )
    assert ((eyes[:, 2] % 6.0 >= 1.5) & (eyes[:, 2] % 6.0 <= 1.9)).all()
    assert 5 <= np.linalg.norm(eyes[-1] - eyes[0]) <= 20
    corners = plant._corners(plant.Parameters(**parameters))
    farthest = np.linalg.norm(corners[:, None] - lights, axis=-1).max()
    assert farthest <= config.shadow_volumes.range <= 10 * farthest + 1


def test_the_eye_in_the_power_plant_is_clear_of_pipes_and_does_not_look_too_steeply(plant):
    mesh = make_mesh("power_plant", 0, {"bays": 5, "floors": 6, "pipes": 880, "tanks": 6, "chimneys": 0})
    walked = FOLDER / "powerplant_lamp.yaml"
    assert not plant.keeps_rules(load_walkthrough(walked), mesh)  # pipes before they left the walkways free
    free = make_mesh("power_plant", 0, dict(load_walkthrough(walked).scene.mesh.parameters))
    steep = load_walkthrough(walked, ["scene.camera.target=[13.68, -6.61, 24]"])
    near = load_walkthrough(walked, ["scene.camera.target=[2, -2, 13]"])
    assert not plant.keeps_rules(steep, free)
    assert not plant.keeps_rules(near, free)


@pytest.mark.parametrize(
    ("place", "distance"),
    [
        ((1.0, 1.0, 0.5), 0.5),  # over the triangle
        ((2.0, -0.3, 0.4), 0.5),  # beside an edge
        ((-0.3, -0.4, 0.0), 0.5),  # beside a corner, in its plane
        ((3.0, 3.0, 0.0), 2**0.5),  # beside the longest edge
    ],
)
def test_distance_of_a_place_from_a_triangle(plant, place, distance):
    corners = np.array([[(0, 0, 0), (4, 0, 0), (0, 4, 0)], [(0, 0, 9), (4, 0, 9), (0, 4, 9)]], float)
    distances = plant._distances(np.array(place), corners)
    assert distances[0] == pytest.approx(distance)
    assert distances[1] > 8


@pytest.mark.parametrize("storey", [-0.5, 2.5])
@pytest.mark.parametrize("lamp", [0.2, 0.8])
def test_drawn_walks_are_where_people_walk(plant, storey, lamp):
    random = np.random.default_rng(5)
    parameters = plant.Parameters(bays=5, floors=6)
    for _ in range(20):
        drawn = {name: random.uniform(*limits) for name, limits in plant.SPACE.items()}
        values = drawn | {"storey": storey, "lamp": lamp}
        eyes, lights = plant._eyes(values, parameters), plant._lights(values, parameters)
        beside = -15.0 - eyes[:, 0]
        on_walkway = np.abs(eyes[:, 0]) <= 0.5 * plant.WALKWAY - plant.ARMS_LENGTH + 1e-9
        assert ((beside >= 1) & (beside <= 12) if storey < 0 else on_walkway).all()
        assert (np.abs(eyes[:, 1]) <= 15 + 1e-9).all()
        on_lamps_way = (np.abs(lights[:, :2]) <= 15 + 1e-9).all() and np.allclose(
            lights[:, 2] % 6, plant.LAMP_HEIGHT
        )
        outside = (np.linalg.norm(lights - (0, 0, 18), axis=1) >= np.sqrt(2 * 15**2 + 18**2) - 1e-9).all()
        assert on_lamps_way if lamp >= 0.5 else outside


def test_every_other_caster_is_drawn(calibrate):
    tanks = {"bays": 1, "floors": 1, "pipes": 0, "tanks": 6, "chimneys": 0}
    whole, few = calibrate._meshes("power_plant", 1, tuple(tanks.items()), Grouping.PARTS, 2)
    sizes = np.bincount(few.objects)
    assert (sizes[0::2] > 0).all()
    assert not sizes[1::2].any()
    assert len(few.triangles) < (whole.objects >= 0).sum()


def test_two_readings_of_the_power_plant_differ_in_what_is_an_object_alone():
    parts, files = (load_walkthrough(FOLDER / f"{name}.yaml") for name in ("powerplant", "powerplant_files"))
    assert (parts.shadow_volumes.casters, files.shadow_volumes.casters) == ("parts", "objects")
    assert files.scene.mesh.parameters == {**parts.scene.mesh.parameters, "places": 7, "kinds": 4}
    assert (files.frames, files.keyframes) == (parts.frames, parts.keyframes)
    assert files.shadow_volumes.range == parts.shadow_volumes.range
