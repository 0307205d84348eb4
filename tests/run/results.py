"""A small hand-made result of two phases, for tests of what is done with results."""

import numpy as np

from archsim.run.result import Check, Histogram, Result, Statistic

MANIFEST = {
    "archsim": "0.1.0",
    "code_digest": "c0de",
    "scene_digest": "5cene",
    "command": ["archsim", "run", "<made & up>"],
    "wall_seconds": 1.5,
    "packages": {"numpy": "2.0"},
}
CONFIG_YAML = "name: made_up\nscene: {resolution: [4, 3]}\n"

PHASE = {
    "cycles": 123456,
    "instructions": 107715,
    "useful_percent": 87.25,
    "stall.no_work_percent": 1.5,
    "stall.lock_percent": 0.25,
    "stall.l1_percent": 2.0,
    "stall.l2_percent": 4.0,
    "stall.dram_percent": 5.0,
    "stall.l1.lookup_percent": 2.0,
    "stall.l2.mshr_percent": 4.0,
    "stall.dram.bus_percent": 5.0,
    "dram.reads": 800,
    "dram.writes": 200,
    "dram.row_hits": 300,
    "dram.row_misses": 100,
    "dram.row_conflicts": 600,
    "dram.bandwidth_bytes_per_cycle": 7.75,
    "dram.bus_percent": 20.5,
    "dram.bytes": 956784,
}
CACHE = {
    "accesses": 7654,
    "hit_percent": 71.5,
    "hits": 5472,
    "merges": 182,
    "misses": 2000,
    "fetches": 1999,
    "writebacks": 333,
    "average_miss_cycles": 98.75,
    "port_percent": 43.5,
}


def make_result(**changes) -> Result:
    """A result whose every field has something in it."""
    statistics = [Statistic("workload.samples", 12, "samples", "Pixels that show geometry.")]
    for phase in ("izb_build", "izb_raster"):
        values = {
            **PHASE,
            **{f"{cache}.{key}": value for cache in ("l1", "l2") for key, value in CACHE.items()},
        }
        statistics += [
            Statistic(f"{phase}.{key}", value, "units", "What it is.") for key, value in values.items()
        ]
    shadow = np.zeros((3, 4), np.bool_)
    shadow[0, 1] = shadow[2, 3] = True
    result = Result(
        name="made_up",
        scene_digest="5cene",
        summary={"workload.samples": 12, "izb_build.cycles": 123456, "checks_passed": True},
        statistics=statistics,
        checks=[Check("a law", True, "1 = 1")],
        shadow=shadow,
        histograms=[Histogram("Length of lists", "samples", "cells", np.array([5, 3, 0, 1]))],
        maps={"Fragments of each pixel [fragments]": np.array([[1, np.nan, 2, 9]] * 3, np.float32)},
        latencies={f"izb_build.{level}": np.bincount([1, 1, 20], minlength=128) for level in ("l1", "dram")},
    )
    return result._replace(**changes)
