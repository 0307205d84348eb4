"""Both stages as programs on cores: equal to the units that they stand for, alike in both models, refused by name."""

import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.execute import hsv_stages
from archsim.run import simulate

SMALL = ["scene.resolution=[48,40]", "scene.mesh.parameters.knights=2"]


def run(*overrides):
    return simulate(load_run("runs/hsv_kernels_tiny.yaml", [*SMALL, *overrides]))


def failed(result):
    return [check for check in result.checks if not check.ok]


def test_both_models_play_the_kernels_alike_and_by_the_laws():
    compiled, reference = run(), run("model=reference")
    assert not failed(compiled)
    assert compiled.statistics == reference.statistics
    assert compiled.shadow.any()
    assert compiled.value("hsv_stage1.tasks") == compiled.value("hsv_stage2.tasks") > 0
    assert compiled.value("programmable.slowdown") > 0


def test_the_result_does_not_depend_on_the_number_of_buffers():
    few, many = run("workload.psv_buffers=1", "workload.variant=combined"), run("workload.casters=parts")
    assert not failed(few)
    assert not failed(many)
    assert (few.shadow == many.shadow).all()


def test_kernels_that_do_something_else_are_noticed(monkeypatch):
    right = hsv_stages.attributes

    def wrong(blocks, volume, stages):
        attributes = right(blocks, volume, stages)
        attributes[:, 1, 0] = 0  # the first tile of a block is never met
        return attributes

    monkeypatch.setattr(hsv_stages, "attributes", wrong)
    assert {check.name.split(":")[0] for check in failed(run())} >= {"stage 1", "stage 2"}


@pytest.mark.parametrize(
    ("overrides", "problem"),
    [
        (("machine={base: machines/tiny.yaml}",), "no cores have the role 'hsv_stages'"),
        (("machine.components.locks.count=8",), "the kernels use 256 locks"),
        (
            ("machine.components.processors.locks=null",),
            "'processors' has no locks; stages of shadow volumes",
        ),
        (
            ("workload.fixed_function={base: machines/tiny.yaml}",),
            "must be a pipeline, and this machine has cores",
        ),
        (("workload.fixed_function={base: machines/tiny_pipeline.yaml}",), "has no pool 'psv_buffers'"),
        (("workload.light=1",), "must be below 1"),
        (("workload.psv_buffers=0",), "psv_buffers"),
    ],
)
def test_runs_that_cannot_be_played_are_refused(overrides, problem):
    with pytest.raises(ArchsimError, match=problem):
        run(*overrides)
