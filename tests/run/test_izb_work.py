"""Recorded work gives the same counters as a run that executes and plays at once."""

import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.machine.build import phase_machine
from archsim.machine.play import play
from archsim.run import simulate
from archsim.run.izb_work import record, replay


def test_replaying_twice_equals_the_run():
    config = load_run("runs/tiny.yaml", ["scene.resolution=[32, 24]"])
    result = simulate(config)
    (work,) = record(config)
    for _ in range(2):
        for role in ("izb_build", "izb_raster"):
            spec = phase_machine(config.machine, role).spec
            counters = play("compiled", spec, replay(work, role, spec))
            assert counters.cycles == result.value(f"{role}.cycles")
            assert int(counters.useful.sum()) == result.value(f"{role}.instructions")


def test_tiles_dealt_to_other_threads_are_not_replayed():
    config = load_run("runs/tiny.yaml", ["scene.resolution=[32, 24]", "workload.tile_order=block"])
    (work,) = record(config)
    more = load_run("runs/tiny.yaml", ["machine.components.builder.threads=3"])
    with pytest.raises(ArchsimError, match="tiles or nodes were dealt to 2 threads, the machine has 3"):
        replay(work, "izb_build", phase_machine(more.machine, "izb_build").spec)
    assert replay(work, "izb_raster", phase_machine(more.machine, "izb_raster").spec).num_tasks > 0


def test_a_machine_that_cannot_hold_the_run_is_refused_by_name():
    small = ["machine.components.dram.rows=1", "machine.components.locks.count=64"]
    with pytest.raises(ArchsimError) as refused:
        simulate(load_run("runs/tiny.yaml", small))
    text = str(refused.value)
    assert "256 locks, the machine's `locks` has count 64" in text
    assert "the machine's `dram` holds 2048" in text
