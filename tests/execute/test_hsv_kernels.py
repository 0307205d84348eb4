"""`kernels/hsv_stage1.s` and `hsv_stage2.s`, executed on real data, do what the fixed-function stages do."""

import numpy as np
import pytest

from archsim.execute import hsv_stages
from archsim.execute.hsv_memory import classification, lay_out, set_tile_states, tile_states
from archsim.execute.interpreter import execute
from archsim.isa.assembler import load_kernel
from archsim.shadow_volumes.casters import Grouping
from archsim.shadow_volumes.hierarchical import LIT, MIXED, SHADOWED, new_memory, settle_all, update
from archsim.shadow_volumes.seen import new_space
from archsim.shadow_volumes.stage1 import classify
from archsim.shadow_volumes.stencil import values
from archsim.shadow_volumes.tiles import screen
from archsim.shadow_volumes.volumes import Counting
from tests.shadow.scenes import soup
from tests.shadow_volumes.scenes import RESOURCES, method, prepared

CHOICES = [
    {},
    {"counting": Counting.ADAPTIVE, "grouping": Grouping.PARTS},
    {"grouping": Grouping.TRIANGLES, "tile": 4},
    {"reach": 3.0, "grouping": Grouping.WHOLE, "tile": 16},
]


def fixed_function(seen, num_buffers):
    """What every volume does, step by step: its classification, (pixels, depth tiles), tile states afterwards."""
    space, memory = (
        new_space(seen.screen),
        new_memory(seen.screen, RESOURCES._replace(num_psv_buffers=num_buffers)),
    )
    early = np.zeros(len(seen.bounds), np.int64)
    for volume in range(len(early)):
        span = tuple(seen.volumes.starts[volume : volume + 2])
        classify(volume, span, seen, space, memory[0])
        psv = memory[0][0]
        found = psv.boundary[volume % num_buffers].copy(), psv.stencil[volume % num_buffers].copy()
        counts = update(volume, span, early, seen, space, memory)
        settle_all(seen.screen, *memory[1])
        yield found, counts, memory[1][1].state.copy(), values(seen.screen, memory[1][0])


@pytest.mark.parametrize("choice", CHOICES, ids=str)
@pytest.mark.parametrize(("seed", "num_buffers"), [(0, 1), (1, 2), (2, 5)])
def test_equal_to_the_fixed_function_stages(choice, seed, num_buffers):
    seen = prepared(soup(seed, 20), method(**choice)).seen
    stages = hsv_stages.prepare_stages(seen, num_buffers)
    expected = fixed_function(seen, num_buffers)
    for batch in stages.batches():
        list(hsv_stages.clear_work(stages).chunks)
        list(hsv_stages.classify_work(stages, batch).chunks)
        found = [classification(stages.memory, volume % num_buffers, seen.screen) for volume in range(*batch)]
        drawn = [hsv_stages.NOTHING] * len(seen.bounds)
        list(hsv_stages.update_work(stages, batch, drawn).chunks)
        for (boundary, stencil), own, volume in zip(found, drawn[batch[0] :], expected, strict=False):
            np.testing.assert_array_equal(boundary, volume[0][0])
            np.testing.assert_array_equal(stencil, volume[0][1])
            assert (own.pixels, own.depth_tiles) == tuple(volume[1])
            last = volume
        np.testing.assert_array_equal(tile_states(stages.memory, seen.screen), last[2])
        np.testing.assert_array_equal(values(seen.screen, stages.stencil), last[3])
    assert choice or MIXED in last[2]


def run_stage(kernel, memory, relation, operation):
    """One task on the first block."""
    attributes = np.zeros((1, 3, 4), np.float32)
    attributes[0, 0, 3], attributes[0, 1], attributes[0, 2] = operation, relation, (7, 8, 9, 10)
    return execute(load_kernel(kernel), attributes, hsv_stages.constants(), memory.windows, memory.words)


@pytest.fixture
def memory():
    seen = prepared(soup(0, 2), method()).seen
    return lay_out(seen.screen, 1)


@pytest.mark.parametrize(
    ("relation", "operation", "stencil", "boundary", "instructions"),
    [
        ((0, 0, 0, 0), 1, 0, 0, 6),  # nothing is met: PSV entry untouched
        ((-1, -1, 0, 0), 0, 0, 0, 6),  # counts, but the sample is not covered
        ((-1, -1, -1, -1), -1, -1, 0, 16),
        ((-1, 0, 1, -1), 1, 1, 0b0110, 16),  # tiles that it doesn't count in become boundary tiles
        ((0, 1, 0, 0), 1, 0, 0b0010, 16),  # cuts only: the sample means nothing
    ],
)
def test_stage_1_on_one_block(memory, relation, operation, stencil, boundary, instructions):
    done = run_stage("hsv_stage1", memory, relation, operation)
    assert memory.words[:2].tolist() == [stencil, boundary]
    assert done.num_instructions == instructions
    run_stage("hsv_stage1", memory, relation, operation)
    assert memory.words[:2].tolist() == [2 * stencil, boundary]  # bits are set once


def test_stage_2_on_one_block(memory):
    low, smin, fs = memory.windows[1].base // 4, slice(0, 4), slice(4, 8)
    state = memory.words[low : low + 8]
    memory.words[:2] = 3, 0b0011  # in the volume's shadow; the first two tiles are boundary tiles
    state[smin] = 0, 2, 1, 1
    done = run_stage("hsv_stage2", memory, (1, -1, 1, 0), 0)
    assert done.emitted_address.tolist() == [7]  # tile 8 was in shadow before
    assert memory.words[1] == 0b0111_0011
    assert state[fs].tolist() == [0, 1, 1, 0]
    assert state[smin].tolist() == [
        0,
        2,
        2,
        1,
    ]  # the third is in shadow as a whole now; the fourth was not met

    state[smin] = 2, 2, 0, 2  # drawn since; FS is not looked up again, save in the tile that is met first
    done = run_stage("hsv_stage2", memory, (1, 1, 1, 1), 0)
    assert done.emitted_address.tolist() == [7]
    assert state[fs].tolist() == [0, 1, 1, 1]


def test_tiles_of_an_odd_screen_find_their_block():
    odd = screen(np.zeros((20, 28), np.float32), 0.1, 4)  # 5 rows of 7 tiles
    memory = lay_out(odd, 3)
    states = np.arange(35, dtype=np.uint8) % 3
    set_tile_states(memory, np.arange(35), states, odd)
    np.testing.assert_array_equal(tile_states(memory, odd), states)
    assert set(states) == {LIT, SHADOWED, MIXED}
