"""The kernels in `kernels/izb_*.s`, executed on real data, equal the plain algorithm to the bit."""

import numpy as np
import pytest

from archsim.errors import ArchsimError
from archsim.execute import izb_memory
from archsim.execute.izb_build import build_work, tile_order
from archsim.execute.izb_clear import clear_work
from archsim.execute.izb_memory import LISTS, Storage, Structure
from archsim.execute.izb_raster import raster_work
from archsim.raster.eye_view import eye_view
from archsim.shadow.grid import Grid
from archsim.shadow.pixel_tiles import cut
from archsim.shadow.plain import Method, grid_fragments, plan_faces, run_face
from archsim.shadow.transform import LightTransform
from archsim.trace.records import Op, num_instructions
from tests.shadow.scenes import soup

METHODS = [
    Method(Grid(64, 48, 32, 16, 4, 4), (4, 4), 1 / 64),
    Method(Grid(24, 8, 8, 8, 8, 2), (8, 8), 1 / 64),
    Method(Grid(64, 64, 128, 128, 2, 16), (2, 3), 0.0),
]


def executed(scene, method, block=False, storage=LISTS):
    """(plan, memory, outcome, emitted samples, emitted depths, build tasks) of each light view."""
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    for plan in plan_faces(scene, seen, scene.lights[0], method):
        order = tile_order(plan.tiles, 3, block)
        per_tile = plan.tiles.num_pairs * 2
        expected = run_face(plan, method.grid, (order[:, None] * per_tile + np.arange(per_tile)).ravel())
        memory = izb_memory.lay_out(method.grid, plan.tiles, order, storage)
        build = list(build_work(memory, method.grid, plan.tiles, plan.transform, order).chunks)
        cells = grid_fragments(plan, izb_memory.stencil(memory, method.grid), method.grid)
        out = [np.empty(0, np.int64)], [np.empty(0, np.float32)]
        work = raster_work(
            memory,
            method.grid,
            plan.occluders,
            cells,
            lambda s, d, out=out: (out[0].append(s), out[1].append(d)),
        )
        list(work.chunks)
        yield plan, memory, expected, np.concatenate(out[0]), np.concatenate(out[1]), build


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("block", "storage"),
    [
        (False, LISTS),
        (True, LISTS),
        (True, Storage(pool_threads=3)),
        (False, Storage(by_tiles=True)),
        (False, Storage(head_bytes=16)),
    ],
)
def test_equal_to_the_plain_algorithm(method, seed, block, storage):
    for plan, memory, expected, samples, depths, _ in executed(soup(seed, 30), method, block, storage):
        placed = expected.samples.cell[:, 0] >= 0
        nodes = izb_memory.nodes(memory)
        np.testing.assert_array_equal(nodes[placed, :3], expected.samples.position[placed])
        np.testing.assert_array_equal(izb_memory.heads(memory, method.grid), expected.lists.head)
        following = izb_memory.following(memory)
        np.testing.assert_array_equal(following[placed], expected.lists.following[placed])
        np.testing.assert_array_equal(izb_memory.stencil(memory, method.grid), expected.lists.stencil)
        np.testing.assert_array_equal(samples, expected.fragments.sample)
        np.testing.assert_array_equal(depths, expected.fragments.depth)
        assert plan.face.taken.sum() == placed.sum()


def test_the_build_does_the_same_work_for_every_pair():
    """[Johnson04] table 3: useful cycles per point are equal in all scenes; 39 instructions a pair, one a tile."""
    for seed in range(3):
        for plan, _, _, _, _, chunks in executed(soup(seed), METHODS[0]):
            for tasks in chunks:
                assert num_instructions(tasks) == tasks.num_tasks * (39 * plan.tiles.num_pairs + 1)
                operations = np.bincount(tasks.records["op"], minlength=6)
                pairs = tasks.num_tasks * plan.tiles.num_pairs
                assert operations[Op.LOAD] == 3 * pairs
                assert operations[Op.STORE] == 6 * pairs
                assert operations[Op.LOCK] == operations[Op.UNLOCK] == 2 * pairs


def test_tile_orders_deal_every_populated_tile_once():
    image = np.ones((16, 40), np.float32)
    taken = np.ones_like(image, np.bool_)
    taken[:4, :8] = False
    tiles = cut(image, taken, (4, 4))
    interleaved = tile_order(tiles, 3, block=False)
    block = tile_order(tiles, 3, block=True)
    np.testing.assert_array_equal(interleaved, np.arange(2, 40))
    np.testing.assert_array_equal(np.sort(block), interleaved)
    np.testing.assert_array_equal(block[0::3], np.arange(2, 15))


def test_too_many_samples_for_a_float_are_refused():
    tiles = cut(np.ones((4, 4), np.float32), np.ones((4, 4), np.bool_), (4, 4))
    with pytest.raises(ArchsimError, match=r"2\^24"):
        izb_memory.lay_out(Grid(8192, 4096, 8, 8, 8, 8), tiles, np.arange(1))


def test_pixels_lie_row_by_row_or_tile_by_tile():
    """The nodes that the first task stores, by hand: two tiles of 4 x 2 pixels side by side."""
    image = np.ones((2, 8), np.float32)
    grid, tiles = Grid(8, 8, 8, 8, 8, 8), cut(image, np.ones_like(image, np.bool_), (4, 2))
    transform = LightTransform(
        *np.zeros((2, 4), np.float32), np.ones(4, np.float32), np.zeros((4, 4), np.float32)
    )
    for storage, expected in (
        (LISTS, [0, 1, 2, 3, 8, 9, 10, 11]),
        (Storage(by_tiles=True), [0, 1, 2, 3, 4, 5, 6, 7]),
    ):
        memory = izb_memory.lay_out(grid, tiles, np.arange(2), storage)
        (tasks,) = build_work(memory, grid, tiles, transform, np.arange(2)).chunks
        records = tasks.records[: tasks.starts[1]]
        first_node = memory.windows[1].base + memory.first_node * 16
        nodes = records["address"][(records["op"] == Op.STORE) & (records["address"] >= first_node)]
        assert ((nodes - first_node) // 16).tolist() == expected
        depths = records["address"][
            (records["op"] == Op.LOAD) & (records["address"] < memory.windows[1].base)
        ]
        assert (depths // 8 - memory.first_pair).tolist() == [node // 2 for node in expected[::2]]


TREES = Storage(structure=Structure.KD_TREE)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("storage", [TREES, TREES._replace(pool_threads=3)])
def test_trees_give_the_same_fragments_in_another_order(method, seed, storage):
    for _, memory, expected, samples, depths, _ in executed(soup(seed, 30), method, storage=storage):
        found = sorted(zip(samples.tolist(), depths.tolist(), strict=True))
        wanted = sorted(
            zip(expected.fragments.sample.tolist(), expected.fragments.depth.tolist(), strict=True)
        )
        assert found == wanted
        np.testing.assert_array_equal(izb_memory.stencil(memory, method.grid), expected.lists.stencil)


def test_a_tree_splits_in_turn_and_leads_on():
    """Every node's way on is the nearest ancestor that it is to the left of; axes alternate from x at the root."""
    (_, memory, expected, *_), *_ = executed(soup(1, 30), METHODS[1], storage=TREES)
    nodes, first = izb_memory.nodes(memory), memory.first_node
    num_seen = 0

    def walk(node, by_y, way_on):
        nonlocal num_seen
        x, y, left, right = nodes[int(node) - first]
        num_seen += 1
        assert (x < 0) == by_y
        for child, smaller in ((left, True), (right, False)):
            if child > 0:
                here, there = (
                    (nodes[int(child) - first, 1], y) if by_y else (abs(nodes[int(child) - first, 0]), abs(x))
                )
                assert (here < there) == smaller
                walk(child, not by_y, node if smaller else way_on)
        if right <= 0:
            assert -right == way_on

    for root in izb_memory.heads(memory, METHODS[1].grid):
        if root >= 0:
            walk(root + first, False, 0)
    assert num_seen == (expected.samples.cell[:, 0] >= 0).sum()


def test_fewer_locks_are_shared():
    (*_, build), *_ = executed(soup(1, 30), METHODS[0], storage=Storage(num_locks=2))
    records = np.concatenate([tasks.records for tasks in build])
    locking = np.isin(records["op"], [Op.LOCK, Op.UNLOCK])
    assert set(records["address"][locking].tolist()) == {0, 1}
    assert records["address"][~locking].max() > 1


def test_heads_of_16_bytes_lie_apart_and_before_the_nodes():
    """The k-th word of packed heads becomes the k-th 16 bytes; all other accesses move with the nodes or not at all."""
    (_, memory, *_, packed), *_ = executed(soup(1, 30), METHODS[0])
    (_, wide_memory, *_, wide), *_ = executed(soup(1, 30), METHODS[0], storage=Storage(head_bytes=16))
    num_heads, base = METHODS[0].grid.num_physical_cells, memory.windows[1].base
    assert wide_memory.windows[1].base == base
    assert (memory.first_node, wide_memory.first_node) == (num_heads // 4, num_heads)

    before, after = (np.concatenate([tasks.records for tasks in build]) for build in (packed, wide))
    access = np.isin(before["op"], [Op.LOAD, Op.STORE])
    inside = access & (before["address"] >= base) & (before["address"] < memory.windows[1].guard(16))
    head, node = inside & (before["bytes"] == 4), inside & (before["bytes"] == 16)
    np.testing.assert_array_equal(after["address"][head] - base, 4 * (before["address"][head] - base))
    assert set(after["bytes"][head].tolist()) == {16}
    assert set((after["address"][node] - before["address"][node]).tolist()) == {12 * num_heads}
    elsewhere = ~access | (before["address"] < base)
    np.testing.assert_array_equal(after[elsewhere], before[elsewhere])


def test_clearing_touches_heads_and_stencil_and_nothing_else():
    scene = soup(1, 30)
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    grid = Grid(10, 5, 8, 8, 2, 1)  # 50 words of stencil: the last element is not full
    (plan,) = plan_faces(scene, seen, scene.lights[0], Method(grid, (4, 4), 0.0))[:1]
    memory = izb_memory.lay_out(grid, plan.tiles, np.arange(len(plan.tiles.origins)))
    before = memory.words.copy()
    memory.words[:50] = 7
    first_head = memory.windows[1].base // 4
    memory.words[first_head : first_head + 64] = 7

    (tasks,) = clear_work(memory, grid).chunks

    np.testing.assert_array_equal(memory.words, before)
    assert (tasks.records["op"] == Op.STORE).sum() == 13 + 16
    wide = memory._replace(storage=Storage(head_bytes=16))
    (tasks,) = clear_work(wide, grid).chunks
    assert (tasks.records["op"] == Op.STORE).sum() == 13 + 64
