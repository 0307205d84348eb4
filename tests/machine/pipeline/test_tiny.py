"""The packaged teaching pipeline: built, played by both models, refused other work."""

import pytest

from archsim.config import load_machine
from archsim.errors import ArchsimError
from archsim.machine.pipeline.build import pipeline_machine
from archsim.machine.pipeline.play import play
from archsim.machine.play import MODELS
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.delay_stream.spec import Overflow
from archsim.model.unit.spec import NO_MEMORY, Slot
from archsim.trace.stream import PipelineWork
from tests.machine.pipeline.build import acquire, emit, load, mark, release, store, take, tasks


@pytest.fixture(scope="module")
def machine():
    return pipeline_machine(load_machine("machines/tiny_pipeline.yaml"))


def objects(num_triangles: list[int]) -> PipelineWork:
    """Objects of so many triangles, each of which covers 16 pixels of a tile of its own."""
    setup, classify, shade, blend = [], [], [], []
    for count in num_triangles:
        for k in range(count):
            first, last = k == 0, k == count - 1
            setup.append([emit()])
            classify.append([take(), *[acquire()] * first, emit(0, 16), *[mark()] * last])
            shade.append([take(), 16, emit(), *[release()] * last])
            blend.append([take(), load(k * 32, 32), store(k * 32, 32)])
    units = ("setup", "classify", "shade", "blend")
    return PipelineWork(units, iter([tuple(tasks(each) for each in (setup, classify, shade, blend))]))


def test_the_machine_has_the_numbers_of_its_file(machine):
    spec = machine.spec
    setup, classify, shade, blend = spec.units

    assert machine.channels == ("triangles", "lit", "held")
    assert (setup.inputs, setup.outputs, classify.outputs, shade.inputs) == ((), (0,), (2,), (2,))
    assert (classify.pools, shade.pools, spec.pools[0].num_tokens) == ((0,), (0,), 2)
    assert (setup.interval_cycles, setup.latency_cycles, shade.lanes) == (4, 6, 4)
    assert (setup.memory, blend.memory, blend.line_bytes) == (NO_MEMORY, 0, 32)
    assert (spec.delay_streams[0].ring_bytes, spec.delay_streams[0].overflow) == (256, Overflow.RELEASE)
    assert spec.caches[0].parent == DRAM_PARENT
    assert spec.dram.row.shift == 5 + 5 + 1  # offset, line, bank


@pytest.mark.parametrize("model", MODELS)
def test_it_plays_objects(machine, model):
    counters = play(model, machine, objects([3, 5, 20]))

    assert counters.unit_tasks.tolist() == [28] * 4
    assert counters.stream_bytes.tolist() == [28 * 16]
    assert counters.stream_marks.tolist() == [3]
    assert counters.stream_early.tolist() == [20 - 16]
    assert counters.pool_acquired.tolist() == counters.pool_released.tolist() == [3]
    assert counters.unit_slots.sum(axis=1).tolist() == [counters.cycles] * 4
    assert counters.unit_slots[2, Slot.BUSY] == 28 * 4


def test_work_for_other_units_is_refused(machine):
    work = objects([1])
    wrong = work._replace(units=("setup", "clasify", "shade", "blend"))

    with pytest.raises(
        ArchsimError, match="no unit 'clasify', for which there is work; did you mean 'classify'"
    ):
        play("reference", machine, wrong)
    with pytest.raises(ArchsimError, match="the work is for the units setup, classify"):
        play("reference", machine, work._replace(units=work.units[:2]))


def test_a_machine_of_cores_is_no_pipeline():
    with pytest.raises(ArchsimError, match="machine 'tiny' has no units with inputs and outputs"):
        pipeline_machine(load_machine("machines/tiny.yaml"))
