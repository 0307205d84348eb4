"""Frames that are kept: a walkthrough that was killed goes on at the next one, with the same result."""

import numpy as np
import pytest

from archsim import resources
from archsim.config import load_walkthrough
from archsim.run import frames, walkthrough
from archsim.run.folder import result_json
from archsim.run.frames import keep, kept, kept_place
from archsim.run.walkthrough import scenes, simulate_walkthrough

SIMPLE = resources.experiment("aila2004") / "simple.yaml"


def small(*overrides):
    return load_walkthrough(SIMPLE, ["scene.resolution=[64,48]", "frames=3", *overrides])


class Killed(Exception):
    """Instead of a signal."""


@pytest.fixture
def drawn(monkeypatch):
    """The numbers of frames drawn by simulate_walkthrough; it dies when told to draw more than `most`."""
    real, counted = walkthrough.draw_frame, {"frames": 0, "most": 100}

    def counting(*arguments):
        if counted["frames"] == counted["most"]:
            raise Killed
        counted["frames"] += 1
        return real(*arguments)

    monkeypatch.setattr(walkthrough, "draw_frame", counting)
    return counted


def test_a_killed_walkthrough_goes_on_at_the_next_frame(tmp_path, drawn):
    whole = simulate_walkthrough(small())
    drawn.update(frames=0, most=2)
    with pytest.raises(Killed):
        simulate_walkthrough(small(), folder=tmp_path / "frames")
    assert len(list((tmp_path / "frames").iterdir())) == 2

    drawn.update(most=3)
    told = {}
    resumed = simulate_walkthrough(
        small(), lambda what, done, total: told.update({what: (done, total)}), tmp_path / "frames"
    )
    assert drawn["frames"] == 3
    assert result_json(resumed) == result_json(whole)
    np.testing.assert_array_equal(resumed.shadow, whole.shadow)
    (layers,) = resumed.histograms
    assert layers.counts.tolist() == whole.histograms[0].counts.tolist()
    assert layers.counts.sum() == 3 * 64 * 48
    assert set(told) == {"brute_force", "depth_bounds", "hierarchical"}
    assert all(done == total for done, total in told.values())


def test_a_frame_that_is_kept_comes_back_as_it_was(tmp_path):
    config = small()
    scene = next(scenes(config))
    frame = frames.draw_frame(
        scene,
        scene.lights[0].position,
        walkthrough.method_of(config.shadow_volumes, walkthrough.resources_of(config.shadow_volumes)),
    )
    keep(tmp_path / "a.npz", frame)
    again = kept(tmp_path / "a.npz")
    np.testing.assert_array_equal(again.shadow, frame.shadow)
    assert again._replace(shadow=None) == frame._replace(shadow=None)


@pytest.mark.parametrize(
    "override", ["shadow_volumes.tile=4", "scene.lights.0.position=[0, 0, 9]", "scene.resolution=[64,47]"]
)
def test_another_frame_has_another_place(tmp_path, override):
    places = {
        kept_place(tmp_path, next(scenes(config)), config.shadow_volumes)
        for config in (small("keyframes=[{}]"), small("keyframes=[{}]", override))
    }
    assert len(places) == 2


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x03\x04 broken"])
def test_what_cannot_be_read_is_no_frame(tmp_path, content):
    (tmp_path / "a.npz").write_bytes(content)
    assert kept(tmp_path / "a.npz") is None
    assert kept(tmp_path / "none.npz") is None
