"""Whole runs: both models, several light views, nothing to see, and the laws that every run obeys."""

import json

import numpy as np
import pytest

from archsim.config import load_run
from archsim.run import simulate
from archsim.run.progress import silent
from archsim.scene.scene import load_scene
from archsim.shadow import ray_trace

TINY = "runs/tiny.yaml"
SMALL = ["scene.resolution=[32, 24]"]


@pytest.fixture(scope="module")
def tiny():
    return simulate(load_run(TINY, SMALL))


def plain(result):
    """All that two runs must agree on, as text."""
    statistics = [(row.name, row.value) for row in result.statistics]
    return json.dumps([result.summary, statistics, [tuple(check) for check in result.checks]])


def test_both_models_give_the_same_result(tiny):
    reference = simulate(load_run(TINY, [*SMALL, "model=reference"]))
    assert plain(reference) == plain(tiny)
    np.testing.assert_array_equal(reference.shadow, tiny.shadow)


def test_the_same_run_gives_the_same_result(tiny):
    assert plain(simulate(load_run(TINY, SMALL))) == plain(tiny)


def test_what_the_raster_kernel_spends_on_pixels_and_on_fragments_is_all_of_it(tiny):
    """5 instructions a grid fragment are no pixel's."""
    on_pixels = np.nansum(tiny.maps["Issue cycles of the raster kernel on each pixel [cycles]"])
    on_fragments = 5 * tiny.value("workload.grid_fragments_post_stencil")
    assert on_pixels + on_fragments == tiny.value("izb_raster.instructions")


def test_every_law_holds(tiny):
    assert tiny.checks
    assert [check for check in tiny.checks if not check.ok] == []


def test_statistics_have_one_definition_each(tiny):
    names = [row.name for row in tiny.statistics]
    assert len(names) == len(set(names))
    assert all(row.unit and row.description.endswith(".") for row in tiny.statistics)
    assert all(np.isfinite(row.value) for row in tiny.statistics)


def test_the_mask_is_the_ray_tracers(tiny):
    traced = ray_trace.shadow_mask(load_scene(load_run(TINY, SMALL).scene), 0)
    assert traced.any()
    assert (tiny.shadow != traced).mean() < 0.01


def test_a_light_among_the_samples_takes_several_views_and_still_holds_every_law():
    result = simulate(load_run(TINY, [*SMALL, "scene.lights=[{position: [0.1, -0.3, 0.2]}]"]))
    assert result.value("workload.light_views") > 1
    assert result.ok
    assert result.value("workload.samples") == result.histograms[1].counts.sum()


def test_a_picture_of_nothing_costs_nothing():
    away = ["scene.camera.target=[0, -100, 50]"]
    result = simulate(load_run(TINY, [*SMALL, *away]))
    assert result.value("workload.samples") == 0
    assert result.value("izb_build.cycles") == result.value("izb_raster.cycles") == 0
    assert result.ok
    assert not result.shadow.any()


def test_tile_order_changes_time_but_not_the_picture(tiny):
    block = simulate(load_run(TINY, [*SMALL, "workload.tile_order=block"]))
    np.testing.assert_array_equal(block.shadow, tiny.shadow)
    assert block.value("izb_build.instructions") == tiny.value("izb_build.instructions")
    assert block.value("izb_build.cycles") != tiny.value("izb_build.cycles")


def test_progress_tells_all_phases_to_the_end():
    told = {}
    simulate(load_run(TINY, SMALL), lambda what, done, total: told.__setitem__(what, (done, total)))
    assert set(told) == {"izb_clear", "izb_build", "izb_raster"}
    assert all(done == total > 0 for done, total in told.values())
    silent("nothing", 0, 0)


def test_a_broken_law_is_seen(tiny, monkeypatch):
    """Fault seeding: lose one write-back and look for the check that fails."""
    from archsim.machine import compiled
    from archsim.run import counted

    def faulty(model, spec, work, progress, *_):
        counters = compiled.simulate(spec, work, progress)
        counters.cache_writebacks_in[-1] -= 1
        return counters

    monkeypatch.setattr(counted, "play", faulty)
    result = simulate(load_run(TINY, SMALL))
    assert not result.ok
    assert {check.name.split(": ")[1] for check in result.checks if not check.ok} == {
        "lookups",
        "writes into cache 1",
    }


@pytest.mark.parametrize(
    "changed",
    [
        ["workload.structure=kd_tree"],
        ["workload.node_layout=pool"],
        ["workload.pixel_layout=rows"],
        ["workload.head_bytes=16"],
        ["workload.locks=1"],
        ["workload.structure=kd_tree", "workload.node_layout=pool", "workload.tile_order=block"],
    ],
)
def test_storage_and_locks_change_no_picture(tiny, changed):
    other = simulate(load_run(TINY, [*SMALL, *changed]))
    assert other.ok
    np.testing.assert_array_equal(other.shadow, tiny.shadow)
    assert other.value("izb_raster.emitted") == tiny.value("izb_raster.emitted")
    assert plain(other) != plain(tiny)


def test_one_lock_is_fought_for(tiny):
    fought = simulate(load_run(TINY, [*SMALL, "workload.locks=1"]))
    assert fought.value("izb_build.locks.taken") == tiny.value("izb_build.locks.taken")
    assert fought.value("izb_build.locks.waited") > 5 * tiny.value("izb_build.locks.waited")


SMALL_DRAWN = [
    "seed=1",
    "workload.resolution=[160, 128]",
    "workload.logical_grid=[128, 128]",
    "workload.physical_grid=[64, 64]",
    "workload.list_length=6",
    "workload.stencil=[80, 90]",
    "workload.grid_fragments_pre_stencil=26000",
    "workload.grid_fragments_post_stencil=20000",
    "workload.framebuffer_fragments_pre_z=60000",
    "workload.framebuffer_fragments_post_z=19000",
    "workload.patch=[16, 16]",
]


def test_a_drawn_workload_runs_like_any_other():
    result = simulate(load_run("runs/izb_drawn.yaml", SMALL_DRAWN))
    assert result.ok
    assert result.shadow.shape == (128, 160)
    assert result.value("workload.framebuffer_fragments_pre_z") == pytest.approx(60_000, rel=0.01)
    other = simulate(load_run("runs/izb_drawn.yaml", [*SMALL_DRAWN, "workload.triangle_order=random"]))
    assert other.scene_digest != result.scene_digest
    assert other.value("workload.node_visits") == result.value("workload.node_visits")
