"""The tile pipeline's work: the same picture as drawing, every item handed on, and bytes by hand."""

import itertools

import numpy as np
import pytest

from archsim import resources
from archsim.codec.codec import Codec, make_codec
from archsim.codec.lloyd import FirstRow
from archsim.config import load_machine
from archsim.errors import ArchsimError
from archsim.lograster.depth_buffer import draw
from archsim.lograster.evaluators import Design
from archsim.lograster.grid import make_grid
from archsim.lograster.offset import OffsetSpec, Switch
from archsim.lograster.row_table import make_table
from archsim.lograster.work import COMPRESS, DECOMPRESS, FINE, UNITS, Z_CULL, Target, map_bytes, tile_work
from archsim.lograster.z_cache import ZCacheSpec, cache_and_codec, make_z_cache
from archsim.machine.pipeline.build import pipeline_machine
from archsim.machine.pipeline.play import play
from archsim.machine.play import MODELS
from archsim.run.pipeline_metrics import pipeline_checks
from archsim.trace.records import Op

SMALL = ZCacheSpec(2, 2)
LLOYD, PLAIN = make_codec(Codec.LLOYD, granularity_bits=128), make_codec(Codec.NONE)
SQUARE = np.array([(0, 1, 2), (0, 2, 3)], np.int32)


def square(depth, slope=0.0):
    places = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    return np.array([(x, y, depth + slope * x, 1.0) for x, y in places])


def soup(seed, num=40):
    random = np.random.default_rng(seed)
    vertices = np.concatenate(
        [random.uniform(-0.3, 1.3, (3 * num, 3)), random.uniform(0.5, 2, (3 * num, 1))], axis=1
    )
    return vertices, np.arange(3 * num, dtype=np.int32).reshape(-1, 3)


def played(vertices, triangles, target):
    """All records of each unit, and the buffer."""
    work, state = tile_work(vertices, triangles, target)
    chunks = list(work.chunks)
    return [np.concatenate([chunk[unit].records for chunk in chunks]) for unit in range(len(UNITS))], state


def count(records, op):
    return int((records["op"] == op).sum())


@pytest.mark.parametrize("ratio", [1.0, 200.0])
@pytest.mark.parametrize("codec", [LLOYD, PLAIN])
def test_the_buffer_is_that_of_drawing(ratio, codec):
    vertices, triangles = soup(3)
    grid = make_grid(32, 32, ratio)

    _, state = played(vertices, triangles, Target(grid, codec, SMALL))

    assert np.array_equal(state.depth, draw(vertices, triangles, grid).depth)
    assert np.array_equal(state.farthest, state.depth.reshape(8, 4, 8, 4).max(axis=(1, 3)).ravel())


def test_every_item_is_handed_on():
    vertices, triangles = soup(4)
    records, _ = played(vertices, triangles, Target(make_grid(32, 32, 50.0), LLOYD, SMALL))

    for before, after in itertools.pairwise(records):
        assert count(before, Op.EMIT) == count(after, Op.TAKE)
    assert count(records[COMPRESS], Op.TAKE) == count(records[COMPRESS], Op.STORE)


def test_counts_are_those_of_drawing():
    vertices, triangles = soup(5)
    grid = make_grid(32, 32, 50.0)
    records, _ = played(vertices, triangles, Target(grid, LLOYD, SMALL))
    drawn = draw(vertices, triangles, grid).counts

    flush = 1
    assert count(records[FINE], Op.TAKE) == drawn.tiles + flush
    assert count(records[Z_CULL], Op.TAKE) == drawn.covered_tiles + flush


def test_bytes_of_a_square_by_hand():
    """64 tiles, each touched by one or (on the diagonal, 8 of them) two triangles; all fit the cache; flat
    tiles compress to 16 bytes.
    """
    target = Target(make_grid(32, 32), LLOYD, ZCacheSpec(64, 1))
    records, state = played(square(0.5), SQUARE, target)

    assert count(records[Z_CULL], Op.TAKE) == 64 + 8 + 1
    assert count(records[DECOMPRESS], Op.LOAD) == 0  # cleared tiles are not read
    assert records[COMPRESS]["bytes"].sum() == 64 * 16
    assert (state.held_bytes == 16).all()
    plain, _ = played(square(0.5), SQUARE, target._replace(codec=PLAIN))
    assert plain[COMPRESS]["bytes"].sum() == 64 * 48


def test_what_leaves_is_read_back():
    """A cache of one tile: the second square, nearer, reads every tile that the first left in memory."""
    both = np.concatenate([square(0.5), square(0.25)])
    triangles = np.concatenate([SQUARE, SQUARE + 4])
    records, _ = played(both, triangles, Target(make_grid(32, 32), PLAIN, ZCacheSpec(1, 1)))

    assert count(records[DECOMPRESS], Op.LOAD) == 8 + 64 + 8  # diagonal tiles come twice each time
    assert count(records[COMPRESS], Op.STORE) == 2 * (64 + 8)


def test_hidden_tiles_are_culled_by_the_table():
    both = np.concatenate([square(0.25), square(0.5)])
    triangles = np.concatenate([SQUARE, SQUARE + 4])
    records, _ = played(both, triangles, Target(make_grid(32, 32), LLOYD, SMALL))

    assert count(records[Z_CULL], Op.EMIT) == 64 + 8 + 1  # of the second square none


def test_chunks_change_nothing():
    vertices, triangles = soup(6)
    target = Target(make_grid(32, 32, 50.0), LLOYD, SMALL)
    whole, state = played(vertices, triangles, target)

    work, other_state = tile_work(vertices, triangles, target, chunk_tiles=7)
    chunks = list(work.chunks)

    assert len(chunks) > 5
    for unit in range(len(UNITS)):
        assert np.array_equal(np.concatenate([chunk[unit].records for chunk in chunks]), whole[unit])
    assert np.array_equal(state.held_bytes, other_state.held_bytes)


@pytest.mark.parametrize("model", ["reference", "compiled"])
def test_the_papers_machine_plays_it(model):
    """Both models; what the units ask for is what the work says, and compression saves bytes but loses no
    picture.
    """
    machine = pipeline_machine(load_machine(resources.config("machines", "lloyd2007")))
    both = np.concatenate([square(0.5), square(0.25)])
    triangles = np.concatenate([SQUARE, SQUARE + 4])
    counters = {}
    for codec in (LLOYD, PLAIN):
        work, _ = tile_work(both, triangles, Target(make_grid(32, 32), codec, ZCacheSpec(1, 1)))
        counters[codec.codec] = play(model, machine, work)

    compressed, plain = counters[LLOYD.codec], counters[PLAIN.codec]
    assert plain.unit_load_bytes[DECOMPRESS] == (8 + 64 + 8) * 48
    half_drawn = 16 * 48  # diagonal tiles between their two triangles do not compress
    assert compressed.unit_load_bytes[DECOMPRESS] == 64 * 16 + half_drawn
    assert plain.unit_store_bytes[COMPRESS] == 2 * (64 + 8) * 48
    assert all(check.ok for check in pipeline_checks("maps", machine, compressed))
    assert compressed.cycles < plain.cycles
    assert compressed.unit_tasks[FINE] == 2 * (64 + 8) + 1


@pytest.mark.parametrize(
    ("design", "lines"), [(Design.TABLE, 2), (Design.TABLE_FIRST_ROW, 1), (Design.FULL, 0)]
)
def test_table_lines_are_asked_for_once_in_each_pass_over_the_rows(design, lines):
    """32 rows of 4 bytes are 2 lines, their first rows less than one. Regions span all 8 rows of tiles."""
    target = Target(make_grid(32, 32, 50.0), LLOYD, SMALL, table=make_table(design, 4, 1 << 20))
    records, _ = played(square(0.5), SQUARE, target)
    loads = records[FINE][records[FINE]["op"] == Op.LOAD]

    assert len(loads) == lines
    assert (loads["bytes"] == 64).all()
    assert ((loads["address"] - (1 << 20)) // 64).tolist() == list(range(lines))


def test_a_short_buffer_asks_again():
    """One line kept: the second triangle starts over."""
    target = Target(make_grid(32, 32, 50.0), LLOYD, SMALL, table=make_table(Design.TABLE, 1, 0))
    records, _ = played(square(0.5), SQUARE, target)

    assert count(records[FINE], Op.LOAD) == 4
    with pytest.raises(ArchsimError, match="at least one line"):
        make_table(Design.TABLE, 0, 0)


def test_the_machine_with_a_table_plays_it():
    machine = pipeline_machine(load_machine(resources.config("machines", "lloyd2007_table")))
    target = Target(make_grid(32, 32, 50.0), LLOYD, SMALL, table=make_table(Design.TABLE, 4, 1 << 20))
    counters = [play(model, machine, tile_work(square(0.5), SQUARE, target)[0]) for model in MODELS]

    assert counters[0].cycles == counters[1].cycles
    assert counters[0].unit_load_bytes[FINE] == counters[1].unit_load_bytes[FINE] == 2 * 64


def test_two_planes_are_refused():
    split = OffsetSpec(1.0, 0.0, int(Switch.SPLIT))
    with pytest.raises(ArchsimError, match="has to be interpolated"):
        tile_work(square(0.5), SQUARE, Target(make_grid(8, 8), LLOYD, SMALL, offset=split))


@pytest.mark.parametrize(("rows", "columns"), [(32, 32), (20, 36)])
def test_blocks_of_four_tiles_draw_the_same_picture(rows, columns):
    """8 x 8 samples as one: fewer things in the cache, other bytes, the same depths; whole blocks at the edges."""
    vertices, triangles = soup(8)
    grid, codec = make_grid(columns, rows, 50.0), make_codec(Codec.HASSELGREN_TWO_PLANES, side=8)
    records, state = played(vertices, triangles, Target(grid, codec, SMALL))
    drawn = draw(vertices, triangles, grid).depth

    assert state.depth.shape == (-(-rows // 8) * 8, -(-columns // 8) * 8)
    assert np.array_equal(state.depth[:rows, :columns], drawn)
    assert len(state.held_bytes) == (state.depth.size // 64)
    assert state.moved.tolist() == [
        count(records[unit], op) for unit, op in ((DECOMPRESS, Op.LOAD), (COMPRESS, Op.STORE))
    ]
    stores = records[COMPRESS][records[COMPRESS]["op"] == Op.STORE]
    assert (stores["address"] % 256 == 0).all()
    assert stores["address"].max() + 256 <= map_bytes(Target(grid, codec, SMALL))


def test_bytes_of_a_square_in_blocks_by_hand():
    """16 blocks of 8 x 8, plain 192 bytes each, all in the cache until the flush."""
    target = Target(make_grid(32, 32), make_codec(Codec.NONE, side=8), ZCacheSpec(16, 1))
    records, _ = played(square(0.5), SQUARE, target)

    assert records[COMPRESS]["bytes"].sum() == 16 * 192
    assert count(records[DECOMPRESS], Op.LOAD) == 0
    assert map_bytes(target) == 16 * 256


def test_a_section_of_a_machine_is_a_cache_and_a_codec():
    config = load_machine("machines/lloyd2007.yaml", ["components.z_cache.first_row=far"])
    cache, codec = cache_and_codec(config.components["z_cache"])

    assert cache == ZCacheSpec(128, 4)
    assert codec == make_codec(Codec.LLOYD, 4, 128, first_row=FirstRow.FAR)


def test_a_cache_by_its_size():
    assert make_z_cache(48 * 64, 4) == ZCacheSpec(16, 4)
