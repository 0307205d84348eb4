"""Shadow volumes on the paper's pipeline: both models, every variant, overflow and exhaustion."""

import numpy as np
import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.run import simulate
from tests.run.small import KNIGHTS as SMALL_KNIGHTS


def run(*overrides):
    return simulate(load_run("runs/hsv_knights_hierarchical.yaml", [*SMALL_KNIGHTS, *overrides]))


def failed(result):
    return [check for check in result.checks if not check.ok]


@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("workload.variant=brute_force",),
        ("workload.variant=depth_bounds",),
        ("workload.variant=combined",),
        ("workload.submission=twice",),
        ("workload.casters=parts", "workload.counting=adaptive", "machine.components.psv_buffers.count=1"),
        ("workload.casters=whole", "machine.components.delay_stream.size=1 KiB"),
    ],
    ids=lambda overrides: " ".join(overrides) or "hierarchical",
)
def test_both_models_play_every_variant_alike_and_by_the_laws(overrides):
    compiled, reference = run(*overrides), run(*overrides, "model=reference")
    assert not failed(compiled)
    assert compiled.statistics == reference.statistics
    assert compiled.shadow.any()
    assert compiled.value("shadow_volumes.cycles") > 0


def test_the_mask_is_that_of_brute_force_whatever_the_machine():
    masks = [
        run(*overrides).shadow for overrides in ((), ("workload.variant=brute_force",), ("workload.tile=4",))
    ]
    assert (masks[0] == masks[1]).all()
    assert (masks[0] == masks[2]).all()


def test_a_small_delay_stream_releases_triangles_early_and_costs_pixels():
    roomy, tight = (
        run("workload.casters=whole"),
        run("workload.casters=whole", "machine.components.delay_stream.size=1 KiB"),
    )
    assert roomy.value("shadow_volumes.delay_stream.early") == 0
    assert tight.value("shadow_volumes.delay_stream.early") > 0
    assert tight.value("traffic.stencil_pixels") > roomy.value("traffic.stencil_pixels")
    assert (tight.shadow == roomy.shadow).all()


def test_few_psv_buffers_make_stage_1_wait():
    stalls = {
        count: run("workload.casters=parts", f"machine.components.psv_buffers.count={count}").value(
            "shadow_volumes.stage_1.stall.pool_percent"
        )
        for count in (1, 8)
    }
    assert stalls[1] > stalls[8]


def test_the_psv_cache_is_told_when_a_buffer_is_taken_and_when_it_is_released():
    result = run("machine.components.psv_buffers.count=1", "workload.tile=4")
    for stage in ("stage_1", "stage_2"):
        assert result.value(f"shadow_volumes.{stage}.clears") == result.value("workload.volumes") == 3
    cache = [result.value(f"shadow_volumes.psv_cache.{what}_bytes") for what in ("fetched", "written")]
    assert (
        sum(cache) == result.value("traffic.psv") == 0
    )  # a volume fits, and nothing of it is ever written back


@pytest.mark.parametrize(
    ("overrides", "problem"),
    [
        (("machine={base: machines/tiny.yaml}",), "runs on a pipeline, and this machine has cores"),
        (("machine={base: machines/tiny_pipeline.yaml}",), "has no pool 'psv_buffers'"),
        (("workload.light=1",), "must be below 1, not 1: the scene has one light"),
        (("machine.components.delay_stream.address=1 KiB",), "the buffers of this run end at"),
    ],
)
def test_runs_that_cannot_be_played_are_refused(overrides, problem):
    with pytest.raises(ArchsimError, match=problem):
        run(*overrides)


def test_every_read_is_in_the_distribution_of_latencies():
    result = run()
    reads, cache = result.latencies["shadow_volumes.dram"], result.latencies["shadow_volumes.psv_cache"]

    writebacks = result.value("shadow_volumes.psv_cache.writebacks")
    assert reads.sum() == result.value("shadow_volumes.dram.requests") - writebacks
    assert cache.sum() == result.value("shadow_volumes.psv_cache.accesses") + result.value(
        "shadow_volumes.psv_cache.clears"
    )


def test_every_pixel_is_in_the_histogram_of_depth_complexity():
    """72 x 56 pixels; brute force updates more of them, and each as often as the statistics say."""
    hierarchical, brute_force = run(), run("workload.variant=brute_force")

    (few,), (many,) = hierarchical.histograms, brute_force.histograms
    assert few.counts.sum() == many.counts.sum() == 72 * 56
    assert few.counts[0] > many.counts[0]
    for result, found in ((hierarchical, few), (brute_force, many)):
        layers = np.arange(len(found.counts)) @ found.counts
        assert layers == result.value("traffic.stencil_pixels")
