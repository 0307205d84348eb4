"""The reproduction's parts that need no large scene: formulas, counts of maps, pictures, how cells are made."""

import numpy as np
import pytest
import yaml

from archsim import resources
from archsim.codec.codec import Codec, make_codec, tile_bits
from archsim.lograster.depth_buffer import DrawCounts
from archsim.lograster.work import COARSE, FINE
from archsim.reproduce.cells import EXACT, NOT_PRINTED
from archsim.reproduce.lloyd2007 import aliasing, equal_error, tables
from archsim.reproduce.lloyd2007.compression import (
    ALL_CODECS,
    LARGE_CODECS,
    MAPS,
    READINGS,
    RESOLUTIONS,
    Buffers,
)
from archsim.reproduce.lloyd2007.designs import hardware_with
from archsim.reproduce.lloyd2007.equal_error import Equal, Errors
from archsim.reproduce.lloyd2007.pictures import compression_figure, error_figure
from archsim.reproduce.lloyd2007.pipeline import Played
from archsim.reproduce.lloyd2007.views import SCENES, load_walk
from archsim.shadowmap.families import make_maps
from archsim.shadowmap.picture import Aliasing, Picture
from archsim.shadowmap.render import render

PRINTED = yaml.safe_load((resources.experiment("lloyd2007") / "printed.yaml").read_text(encoding="utf-8"))
COUNTS = DrawCounts(1000, 0, 0, 0, 0, 0, 5, 0.4, 0.3)
MEASURED = {
    scene: {
        (kind, size): Buffers(dict.fromkeys(ALL_CODECS, 3840), dict.fromkeys(ALL_CODECS, 1280), COUNTS)
        for kind in MAPS
        for size in RESOLUTIONS
    }
    for scene in SCENES
}


def test_exact_cells_are_equal():
    cells = tables.precision_cells(PRINTED)

    assert {cell.kind for cell in cells} == {EXACT}
    assert [cell.error_percent for cell in cells] == [0, 0, 0, 0, 0]


def test_fig_5c_is_the_scheme_we_encode():
    """The printed grid of bits sums to the 127 that the codec writes."""
    assert sum(map(sum, PRINTED["depth_compression"]["fig5c_bits"])) == 127


def test_offset_cells_by_hand():
    cells = {
        (cell.row, cell.column): cell.ours
        for cell in tables.offset_cells(PRINTED["polygon_offset"], MEASURED)
    }

    assert cells["robots", "triangles_with_switch"] == pytest.approx(0.5)
    assert cells["robots", "mean_of_greatest_difference"] == pytest.approx(0.08)
    assert cells["robots", "mean_over_all_triangles"] == pytest.approx(0.0004)
    assert 0.95 < cells["town", "greatest_difference_possible"] < 1


def test_compression_cells_hold_every_codec_scene_and_resolution():
    cells = tables.compression_cells(MEASURED)

    assert len(cells) == len(SCENES) * len(MAPS) * len(RESOLUTIONS) * len(ALL_CODECS)
    assert {cell.ours for cell in cells} == {3.0}  # 10 tiles of 384 bits in 1280
    assert {cell.column for cell in cells if cell.table == 11} == set(LARGE_CODECS)
    assert {cell.column for cell in cells if cell.table == 6} == set(READINGS)


def test_storage_cells_have_the_papers_powers():
    cells = {(cell.row, cell.column): cell for cell in tables.storage_cells(PRINTED)}

    assert abs(cells["standard", "power of f/n"].error_percent) < 2
    assert abs(cells["fp_lispsm", "power of f/n"].error_percent) < 2
    assert abs(cells["logpsm", "last step over first"].error_percent) < 3


def test_pipeline_cells_by_hand():
    played = Played(Errors(9.0, 0.01), 3, 512 * 512, 2000, 1000, 4096, 2048, 12288, [])
    cells = {cell.column: cell.ours for cell in tables.pipeline_cells({("m", "logpsm, lloyd"): played})}

    assert cells["storage"] == 768
    assert cells["tiles a cycle"] == 0.5
    assert (cells["read"], cells["written"]) == (4, 2)
    assert (cells["plain"], cells["compression"], cells["wrong"]) == (12, 2, 1)


def test_every_measure_of_equality_has_a_table():
    assert set(tables.EQUAL_TABLES) == set(equal_error.MEASURES)
    assert set(tables.EQUAL_TABLES.values()) <= set(tables.PAPER.tables)


def test_colours_of_errors():
    """Green at 1, yellow at 3, red from 10 on, black where maps meet, white where nothing is seen."""
    seen = np.array([[True, True, True], [True, False, True]])
    picture = Picture(seen, np.zeros((5, 3)), np.tile([0.0, 0, 1], (5, 1)))
    errors = Aliasing(np.array([1.0, 3.0, 10.0, 0.2, 99.0]), np.zeros(5, int), np.zeros((5, 2)))
    image = aliasing.error_image(picture, errors)

    assert image[0, 0].tolist() == [0, 158, 115]
    assert image[0, 1].tolist() == [0, 0, 0]  # beside a pixel without surface
    assert image[1, 2].tolist() == [213, 94, 0]
    assert image[1, 1].tolist() == [255, 255, 255]


def test_pictures_need_nothing_outside_the_page():
    picture = Picture(np.ones((4, 4), bool), np.zeros((16, 3)), np.tile([0.0, 0, 1], (16, 1)))
    errors = Aliasing(np.ones(16), np.zeros(16, int), np.arange(32.0).reshape(16, 2))
    family = aliasing.Fitted([], [], errors)

    assert compression_figure(MEASURED).html.startswith("<svg")
    assert 'src="data:image/png;base64,' in error_figure(picture, {"logpsm": family}).html


def test_the_papers_statements_hold_on_the_robots():
    """At 1024 x 1024: on a par when linear; when logarithmic the planar schemes fail and the paper's keeps
    on.
    """
    walk = load_walk("robots")
    frame = walk.frames[0]
    ratios = {}
    for rasterization, family in MAPS.items():
        shadow_map = next(m for m in make_maps(family, frame.view, frame.light) if m.name == "bottom")
        drawn = render(walk.mesh, shadow_map, (1024, 1024))
        for codec in (Codec.LLOYD, Codec.ANCHOR, Codec.DDPCM, Codec.HASSELGREN):
            bits = tile_bits(make_codec(codec), drawn.depth, drawn.touched)
            ratios[rasterization, codec] = 384 * drawn.touched.sum() / bits.sum()

    assert ratios["linear", Codec.LLOYD] > 0.95 * ratios["linear", Codec.HASSELGREN]
    for codec in (Codec.ANCHOR, Codec.DDPCM, Codec.HASSELGREN):
        assert ratios["logarithmic", codec] < 1.4
    assert 2 < ratios["logarithmic", Codec.LLOYD] < ratios["linear", Codec.LLOYD]


@pytest.mark.parametrize(
    ("design", "interval", "latency", "reads"),
    [("full", 1, 15, False), ("full, one exponential", 4, 15, False), ("table of first rows", 1, 9, True)],
)
def test_an_evaluator_s_time_reaches_the_machine(design, interval, latency, reads):
    hardware = hardware_with(design)
    units = hardware.machine.spec.units

    assert (units[FINE].interval_cycles, units[FINE].latency_cycles) == (interval, latency)
    assert units[COARSE].latency_cycles == latency
    assert hardware.evaluator.has_table == reads


def test_tables_that_were_never_printed_say_so():
    assert {cell.kind for cell in tables.evaluator_cells() + tables.bits_cells()} == {NOT_PRINTED}


@pytest.mark.parametrize(("power", "goal"), [(-0.5, 0.25), (-0.3, 0.1), (-1.0, 4.0)])
def test_texels_are_found_that_bring_an_error_to_a_goal(power, goal):
    """An error of texels^power that is 1 at the texels that the search begins with."""

    def attempt(_family, texels):
        return Equal(texels, Errors((texels / equal_error.TEXELS) ** power, 0.0), [])

    found = equal_error._equalled("any", attempt, "m", goal)

    assert found.errors.m == pytest.approx(goal, rel=equal_error.CLOSE)
    assert found.texels == pytest.approx(equal_error.TEXELS * goal ** (1 / power), rel=0.1)


def test_the_scheme_s_statements_by_hand():
    bits = dict.fromkeys(ALL_CODECS, 1000) | {"lloyd": 500}
    worse = dict.fromkeys(ALL_CODECS, 2000) | {"lloyd": 800}
    plain = dict.fromkeys(ALL_CODECS, 2400)
    measured = {
        scene: {
            (kind, size): Buffers(plain, bits if kind == "linear" else worse, COUNTS)
            for kind in MAPS
            for size in RESOLUTIONS
        }
        for scene in SCENES
    }
    cells = {cell.column: cell.ours for cell in tables.statement_cells(measured) if cell.row == "512"}

    assert cells["linear: over the best other"] == cells["linear: over the mean other"] == 2
    assert cells["logarithmic: best other"] == 1.2
    assert cells["logarithmic: own"] == 3
    assert cells["logarithmic over linear: own"] == pytest.approx(0.625)
