"""Requests of a run at each level: as many as the run counts, in order, and playable again."""

import numpy as np
import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.machine.build import group_machine
from archsim.run.export import export
from archsim.run.izb_statistics import BUILD, CLEAR, RASTER
from archsim.run.progress import silent
from archsim.run.replay_timed import Play, replay_with_time

SMALL = load_run("runs/tiny.yaml", ["scene.resolution=[16, 12]"])


def exported(level, phase=None, config=SMALL):
    chunks = []
    result = export(config, level, phase, chunks.append, silent)
    assert result.ok
    return result, np.concatenate(chunks)


@pytest.mark.parametrize(
    ("level", "cache"), [("L1", "builder_l1"), ("l2", "l2"), ("builder_l1", "builder_l1")]
)
def test_a_cache_is_asked_as_often_as_it_counts(level, cache):
    result, accesses = exported(level, "izb_build")

    assert len(accesses) == result.value(f"izb_build.{cache}.accesses")
    assert (np.diff(accesses["cycle"]) >= 0).all()
    assert accesses["cycle"][-1] <= result.value("izb_build.cycles")
    assert set(np.unique(accesses["requester"])) <= {0, 1}


def test_the_dram_is_asked_as_often_as_it_counts_and_phases_follow_each_other():
    result, accesses = exported("dram")
    requests = [result.value(f"{phase}.dram.requests") for phase in (CLEAR, BUILD, RASTER)]

    assert len(accesses) == sum(requests)
    assert (np.diff(accesses["cycle"]) >= 0).all()
    assert set(accesses["bytes"].tolist()) == {64}


def test_private_caches_of_one_name_are_one_level():
    config = load_run("runs/tiny.yaml", ["scene.resolution=[16, 12]", "machine.components.shader.count=3"])
    result, accesses = exported("l1", "izb_raster", config)

    assert len(accesses) == result.value("izb_raster.shader_l1.accesses")
    assert set(np.unique(accesses["requester"])) == set(range(6))


def test_exported_accesses_miss_again_where_they_missed():
    """One thread asks its cache in the same order again."""
    config = load_run("runs/tiny.yaml", ["scene.resolution=[16, 12]", "machine.components.builder.threads=1"])
    result, accesses = exported("L1", "izb_build", config)
    machine = group_machine(config.machine, "builder")
    replay = replay_with_time("t", lambda: iter([accesses]), machine, 0, Play("compiled", 1, silent))

    again = {statistic.name: statistic.value for statistic in replay.statistics}
    for name in ("builder_l1.accesses", "builder_l1.misses", "builder_l1.writebacks", "l2.misses"):
        assert again[name] == result.value(f"izb_build.{name}"), name


def test_what_cannot_be_exported_is_named():
    with pytest.raises(ArchsimError, match="the machine has no level 'l7'"):
        exported("l7")
    with pytest.raises(ArchsimError, match="no phase is named 'izb_rastr'; did you mean 'izb_raster'"):
        exported("l1", "izb_rastr")


def test_the_requests_of_a_pipeline():
    """Units and delay streams ask the DRAM beside the caches."""
    config = load_run("runs/hsv_knights_hierarchical.yaml", ["scene.resolution=[32, 24]"])
    result, accesses = exported("dram", None, config)
    _, cached = exported("psv_cache", "shadow_volumes", config)

    assert len(accesses) == result.value("shadow_volumes.dram.requests")
    assert len(cached) == result.value("shadow_volumes.psv_cache.accesses")
    assert (np.diff(accesses["cycle"]) >= 0).all()
    with pytest.raises(ArchsimError, match="no cache 'psv_cash'; did you mean 'psv_cache'"):
        exported("psv_cash", None, config)
