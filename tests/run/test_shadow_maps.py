"""Shadow maps as runs: both models, every evaluator, codec and family; what is refused."""

import numpy as np
import pytest

from archsim.config import load_run
from archsim.errors import ArchsimError
from archsim.lograster.grid import make_grid
from archsim.run import simulate
from archsim.run.tile_pipeline import hardware_of, rows_of, touched_blocks

M = "machine.components."
EVALUATOR, Z_CACHE = M + "evaluator.", M + "z_cache."
LINEAR = "workload.rasterization=linear"


def run(*overrides):
    return simulate(load_run("runs/lograster_tiny.yaml", overrides))


def failed(result):
    return [check for check in result.checks if not check.ok]


@pytest.mark.parametrize(
    "overrides",
    [
        (),
        (LINEAR, "workload.maps=csm_lispsm"),
        (LINEAR, "workload.sun=[1, 0.5, 2]", "workload.maps=standard"),
        (EVALUATOR + "design=full",),
        (EVALUATOR + "design=table", EVALUATOR + "kept_lines=1"),
        (EVALUATOR + "design=table_first_row",),
        (Z_CACHE + "size=192 B", Z_CACHE + "codec=none"),
        (Z_CACHE + "size=768 B", Z_CACHE + "tile=8", Z_CACHE + "codec=hasselgren_2"),
    ],
    ids=lambda overrides: " ".join(overrides) or "as it is",
)
def test_both_models_play_alike_and_by_the_laws(overrides):
    compiled, reference = run(*overrides), run(*overrides, "model=reference")

    assert not failed(compiled)
    assert compiled.statistics == reference.statistics
    assert compiled.shadow.any()
    assert compiled.value("maps.cycles") > 0


def test_shadows_come_near_to_traced_ones_as_maps_grow():
    wrong = [run(f"workload.texels=[{side}, {side}]").value("image.wrong_percent") for side in (32, 128, 512)]

    assert wrong[0] > wrong[1] > wrong[2]
    assert wrong[2] < 0.5


@pytest.mark.parametrize("maps", ["standard", "lispsm", "fp_lispsm", "csm_lispsm", "logpsm"])
def test_every_family_gives_the_same_shadows_with_many_texels(maps):
    overrides = [] if maps == "logpsm" else [LINEAR]
    result = run(f"workload.maps={maps}", "workload.texels=[1024, 1024]", *overrides)

    assert result.value("image.wrong_percent") < 0.5
    assert 0 < result.value("image.shadow_percent") < 50


@pytest.mark.parametrize("maps", ["standard", "lispsm", "fp_lispsm", "csm_lispsm", "logpsm"])
def test_every_family_takes_a_lamp_that_is_in_the_picture(maps):
    overrides = [] if maps == "logpsm" else [LINEAR]
    lamp = "scene.lights.0.position=[0.1, 0.3, 1]"
    result = run(f"workload.maps={maps}", "workload.texels=[1024, 1024]", lamp, *overrides)

    assert not failed(result)
    assert result.value("maps.count") >= 6
    assert result.value("image.wrong_percent") < 1


def test_what_is_compared_with_nothing_says_nothing_of_it():
    result = run("workload.compare=none")

    assert not [s.name for s in result.statistics if s.name.endswith(("wrong_percent", "dark_percent"))]
    assert "image.wrong_percent" not in result.summary
    assert result.value("image.m_95") == run().value("image.m_95")


def test_bytes_without_compression_are_those_of_a_machine_without_codec():
    small = Z_CACHE + "size=192 B"
    compressed, plain = run(small), run(small, Z_CACHE + "codec=none")

    assert compressed.value("maps.plain_read_bytes") == plain.value("maps.read_bytes") > 0
    assert compressed.value("maps.plain_written_bytes") == plain.value("maps.written_bytes")
    assert plain.value("maps.compression") == plain.value("maps.finished_compression") == 1
    assert (compressed.shadow == plain.shadow).all()


def test_an_evaluator_that_is_too_narrow_takes_four_cycles_a_tile():
    narrow, wide = (run(EVALUATOR + "design=full", EVALUATOR + f"exponentials={n}") for n in (1, 4))

    assert (narrow.value("evaluator.interval"), wide.value("evaluator.interval")) == (4, 1)
    assert wide.value("evaluator.sustains_a_tile_a_cycle") == 1
    assert narrow.value("evaluator.sustains_a_tile_a_cycle") == 0
    assert narrow.value("maps.cycles") > wide.value("maps.cycles")
    assert (narrow.shadow == wide.shadow).all()


def test_only_logarithmic_rows_are_read_from_a_table():
    table = EVALUATOR + "design=table"

    assert run(table).value("maps.table_bytes") > 0
    assert run(table, LINEAR).value("maps.table_bytes") == 0
    assert run().value("maps.table_bytes") == 0


def test_an_evaluator_puts_rows_where_its_design_does():
    coarse = load_run("runs/lograster_tiny.yaml", [EVALUATOR + "constant_bits=12"])
    exact = load_run("runs/lograster_tiny.yaml", [EVALUATOR + "design=full"])
    grid = make_grid(4, 64, 100.0)

    assert np.array_equal(rows_of(hardware_of(exact.machine).parts, 4, 64, 100.0).y, grid.y)
    assert not np.array_equal(rows_of(hardware_of(coarse.machine).parts, 4, 64, 100.0).y, grid.y)


def test_blocks_of_four_tiles_are_touched_with_any_of_them():
    touched = np.zeros((3, 5), np.bool_)
    touched[2, 4] = touched[0, 1] = True

    assert touched_blocks(touched, 8).tolist() == [[True, False, False], [False, False, True]]
    assert np.array_equal(touched_blocks(touched, 4), touched)


@pytest.mark.parametrize(
    ("overrides", "problem"),
    [
        (("machine={base: machines/tiny.yaml}",), "runs on a pipeline, and this machine has cores"),
        (("machine={base: machines/tiny_pipeline.yaml}",), "has no unit 'coarse', which shadow maps need"),
        (("workload.light=1",), "must be below 1, not 1: the scene has one light"),
        (("workload.far=0.05",), "must be above the camera's near, 0.1, not 0.05"),
        (("workload.sun=[0, 0, 0]",), "must not be zero"),
        (("workload.maps=standard",), "must be linear: only the maps of 'logpsm'"),
        ((M + "depth_test.parts=[]", M + "fine.parts=[evaluator, z_cache]"), "'depth_test' must have one"),
        ((M + "dram.rows=1", M + "dram.row_bytes=64 B", "workload.texels=[512, 512]"), "the maps take"),
    ],
)
def test_runs_that_cannot_be_played_are_refused(overrides, problem):
    with pytest.raises(ArchsimError, match=problem):
        run(*overrides)


def test_every_texel_and_touched_block_is_in_a_histogram():
    result = run(Z_CACHE + "codec=none")

    layers, blocks = result.histograms
    fragments = sum(each.value for each in result.statistics if each.name.endswith(".fragments"))
    assert layers.counts.sum() == result.value("maps.texels")
    assert np.arange(len(layers.counts)) @ layers.counts == fragments
    assert np.flatnonzero(blocks.counts).tolist() == [48]  # 4 x 4 samples of 3 bytes


def test_compression_shows_in_the_sizes_of_blocks():
    result = run()

    _, blocks = result.histograms
    held = np.arange(len(blocks.counts)) @ blocks.counts
    assert result.value("maps.finished_compression") == pytest.approx(48 * blocks.counts.sum() / held)
