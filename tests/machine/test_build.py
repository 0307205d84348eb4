"""The packaged machines as the models see them."""

import pytest

from archsim.config import load_machine
from archsim.machine.build import phase_machine
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.core.spec import TaskOrder
from archsim.model.dram.spec import AddressField


@pytest.fixture(scope="module")
def johnson2004():
    return load_machine("machines/johnson2004.yaml")


def test_one_processor_builds(johnson2004):
    """[Johnson04] table 2 and section 6."""
    machine = phase_machine(johnson2004, "izb_build")
    spec = machine.spec
    assert (spec.core.num_cores, spec.core.num_threads, spec.core.period_ticks) == (1, 8, 7)
    assert spec.core.task_order == TaskOrder.INTERLEAVED
    assert spec.locks.num_locks == 256
    assert machine.cache_names == ("cpu_l1", "l2")
    l1, l2 = spec.caches
    assert l1.num_sets * l1.num_ways * l1.line_bytes == 16 * 1024
    assert l2.num_sets * l2.num_ways * l2.line_bytes == 256 * 1024
    assert (l1.num_ways, l1.line_bytes, l1.hit_cycles, l1.parent) == (8, 64, 1, 1)
    assert (l2.num_ways, l2.line_bytes, l2.hit_cycles, l2.parent) == (8, 128, 6, DRAM_PARENT)
    assert machine.tick_hertz == 8_400_000_000


def test_four_processors_with_their_own_l1_rasterize(johnson2004):
    machine = phase_machine(johnson2004, "izb_raster")
    spec = machine.spec
    assert (spec.core.num_cores, spec.core.num_threads) == (4, 8)
    assert spec.core.task_order == TaskOrder.FIRST_FREE
    assert spec.core_cache == (0, 1, 2, 3)
    assert [cache.parent for cache in spec.caches] == [4, 4, 4, 4, DRAM_PARENT]
    assert spec.source.interval_cycles == 0


def test_the_dram_is_line_interleaved_over_channels(johnson2004):
    dram = phase_machine(johnson2004, "izb_build").spec.dram
    assert (dram.num_channels, dram.num_banks, dram.period_ticks) == (8, 4, 12)
    assert (dram.channel, dram.bank, dram.row) == (
        AddressField(7, 3),
        AddressField(14, 2),
        AddressField(16, 12),
    )
    assert dram.num_channels * dram.beat_bytes * 8 == 256


def test_a_shared_first_level_serves_all_cores(johnson2004):
    shared = johnson2004.model_copy(
        update={
            "components": {
                **johnson2004.components,
                "fragment_l1": johnson2004.components["fragment_l1"].model_copy(update={"private": False}),
            }
        }
    )
    spec = phase_machine(shared, "izb_raster").spec
    assert spec.core_cache == (0, 0, 0, 0)
    assert len(spec.caches) == 2
