"""Counters of the packaged tiny run as they are: whoever changes them on purpose changes them here, and says why."""

from archsim.config import load_run
from archsim.run import simulate

TINY = {
    "workload.samples": 1146,
    "workload.framebuffer_fragments_pre_z": 1780,
    "workload.node_visits": 2466,
    "izb_build.cycles": 55588,
    "izb_build.instructions": 32474,
    "izb_build.builder_l1.misses": 3101,
    "izb_build.l2.misses": 2278,
    "izb_build.dram.row_conflicts": 2561,
    "izb_raster.cycles": 41488,
    "izb_raster.instructions": 27652,
    "izb_raster.shader_l1.misses": 2333,
    "izb_raster.l2.misses": 1286,
    "izb_raster.dram.row_hits": 231,
}


def test_the_tiny_run_counts_what_it_counted():
    result = simulate(load_run("runs/tiny.yaml"))
    assert {name: result.value(name) for name in TINY} == TINY
