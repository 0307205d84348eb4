"""Walkthroughs: frames between keyframes, averages, and checks that every variant gives the same mask."""

import numpy as np
import pytest

from archsim import resources
from archsim.config import load_walkthrough
from archsim.errors import ArchsimError
from archsim.run.walkthrough import scene_at, scenes, simulate_walkthrough

SIMPLE = resources.experiment("aila2004") / "simple.yaml"
SMALL = ["scene.resolution=[96,64]", "frames=3"]


def small(*overrides):
    return load_walkthrough(SIMPLE, [*SMALL, *overrides])


def test_frames_are_evenly_spaced_between_keyframes():
    config = small("keyframes=[{light: [0, 0, 4]}, {light: [2, 0, 4]}, {light: [2, 6, 4]}]", "frames=5")
    places = [scene.lights[0].position.tolist() for scene in scenes(config)]
    assert places == [[0, 0, 4], [1, 0, 4], [2, 0, 4], [2, 3, 4], [2, 6, 4]]


def test_a_single_frame_is_the_middle_of_the_walk():
    config = small("keyframes=[{light: [0, 0, 4]}, {light: [2, 0, 4]}]", "frames=1")
    assert next(scenes(config)).lights[0].position.tolist() == [1, 0, 4]


def test_what_a_keyframe_leaves_out_stays():
    config = small("keyframes=[{parameters: {slices: 10}}, {parameters: {slices: 30}}]")
    scene = scene_at(config, 0.5)
    assert scene.mesh.parameters["slices"] == 20
    assert scene.camera == config.scene.camera
    assert scene.lights == config.scene.lights


def test_statistics_are_averages_of_frames():
    walk = simulate_walkthrough(small())
    single = [simulate_walkthrough(small("frames=1", f"keyframes=[{moment}]")) for moment in moments()]
    for name in ("brute_force.stencil_pixels", "hierarchical.total", "walkthrough.triangles"):
        assert walk.value(name) == pytest.approx(np.mean([result.value(name) for result in single]))
    assert walk.ok
    assert walk.value("walkthrough.triangles") == 8


def moments():
    """Each frame as a keyframe."""
    return [
        f"{{eye: {scene.camera.eye.tolist()}, light: {scene.lights[0].position.tolist()}}}"
        for scene in scenes(small())
    ]


def test_progress_reaches_its_end():
    told = {}
    simulate_walkthrough(small(), lambda what, done, total: told.update({what: (done, total)}))
    assert set(told) == {"brute_force", "depth_bounds", "hierarchical"}
    assert all(done == total for done, total in told.values())


@pytest.mark.parametrize(
    ("override", "problem"),
    [
        ("shadow_volumes.light=1", "must be below 1"),
        ("keyframes=[{light: [0, 0, 1]}, {eye: [0, 0, 1]}]", "either all keyframes have 'eye' or none"),
        ("keyframes=[{parameters: {slices: 9}}, {}]", "all keyframes must have the same parameters"),
        ("shadow_volumes.psv_cache.line=3", "must be a power of two"),
        ("shadow_volumes.psv_cache.ways=3", "must be a multiple of line x ways"),
        ("shadow_volumes.casters=object", "casters"),
        ("shadow_volumes.tile=5", "tile"),
        ("frames=0", "frames"),
    ],
)
def test_bad_walkthroughs_are_refused(override, problem):
    with pytest.raises(ArchsimError, match=problem):
        small(override)
