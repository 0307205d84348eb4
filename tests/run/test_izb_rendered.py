"""Work that was rendered, stored and read back gives the same result on every machine."""

import json

import numpy as np
import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.run import simulate
from archsim.run.folder import result_json
from archsim.run.izb import replay_izb
from archsim.run.izb_rendered import depends_on_machine, load, render, save
from archsim.run.progress import silent

SMALL = ["scene.resolution=[32, 24]"]
MACHINES = [[], ["machine.components.l2.size=4KiB", "machine.components.shader.threads=5"]]
SCENES = [[], ["scene.lights=[{position: [0.1, -0.3, 0.2]}]"], ["scene.camera.target=[0, -100, 50]"]]


@pytest.mark.parametrize("scene", SCENES, ids=["one view", "several views", "nothing to see"])
def test_a_stored_rendering_gives_the_runs_own_result(tmp_path, scene):
    save(render(load_run("runs/tiny.yaml", [*SMALL, *scene])), tmp_path)
    rendered = load(tmp_path)

    for machine in MACHINES:
        config = load_run("runs/tiny.yaml", [*SMALL, *scene, *machine])
        for _ in range(2):
            replayed, direct = replay_izb(config, rendered, silent), simulate(config)
            assert result_json(replayed) == result_json(direct)
            np.testing.assert_array_equal(replayed.shadow, direct.shadow)
            assert [h.counts.tolist() for h in replayed.histograms] == [
                h.counts.tolist() for h in direct.histograms
            ]
            assert json.dumps(list(replayed.maps)) == json.dumps(list(direct.maps))
            assert replayed.ok


def test_only_tiles_in_blocks_depend_on_the_machine():
    assert depends_on_machine(load_run("runs/tiny.yaml")) == {}
    assert depends_on_machine(load_run("runs/tiny.yaml", ["workload.tile_order=block"])) == {
        "build_threads": 2
    }


def test_a_machine_that_cannot_hold_the_run_is_refused_at_replay():
    rendered = render(load_run("runs/tiny.yaml", SMALL))
    small = load_run("runs/tiny.yaml", [*SMALL, "machine.components.locks.count=64"])

    with pytest.raises(ArchsimError, match="256 locks, the machine's `locks` has count 64"):
        replay_izb(small, rendered, silent)
