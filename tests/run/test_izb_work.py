"""Recorded work gives the same counters as a run that executes and plays at once."""

from archsim.config import load_run
from archsim.machine.build import phase_machine
from archsim.machine.play import play
from archsim.run import simulate
from archsim.run.izb_work import record, replay


def test_replaying_twice_equals_the_run():
    config = load_run("runs/tiny.yaml", ["scene.resolution=[32, 24]"])
    result = simulate(config)
    (work,) = record(config)
    for _ in range(2):
        for role, chunks in (("izb_build", work.build), ("izb_raster", work.raster)):
            counters = play("compiled", phase_machine(config.machine, role).spec, replay(chunks))
            assert counters.cycles == result.value(f"{role}.cycles")
            assert int(counters.useful.sum()) == result.value(f"{role}.instructions")
