"""Lines that the PSV cache moves, and bytes of the delay stream, counted by hand."""

import numpy as np
import pytest

from archsim.shadow_volumes.delay_stream import popped_early, stream_bytes
from archsim.shadow_volumes.psv_cache import CacheShape, access, new_psv_cache, release
from archsim.shadow_volumes.tiles import screen

SCREEN = screen(
    np.ones((256, 256), np.float32), 0.1, 8
)  # 16 x 16 blocks: 8 x 8 clear areas, 4 a line, 16 lines
SHAPE = CacheShape(64, 32, 2)  # one set of two lines


def moved(accesses, num_buffers=2):
    cache = new_psv_cache(SHAPE, SCREEN, num_buffers)
    for buffer, row, column, write in accesses:
        access(cache, buffer, row, column, write)
    return cache, cache.moved.tolist()


def test_sizes_are_those_of_the_paper():
    tall = screen(np.ones((1024, 1280), np.float32), 0.1, 8)
    cache = new_psv_cache(CacheShape(2048, 32, 4), tall, 1)
    assert cache.lines_per_buffer * 32 == 10 * 1024  # 4 bits a tile
    assert cache.line.shape == (16, 4)


@pytest.mark.parametrize(
    ("accesses", "expected"),
    [
        ([(0, 0, 0, True), (0, 1, 7, True)], [0, 0]),  # one line, clear: no fetch
        ([(0, 0, 0, True), (0, 0, 8, True), (0, 2, 0, True)], [0, 1]),  # a third line evicts the first
        ([(0, 0, 0, True), (0, 0, 8, True), (0, 2, 0, True), (0, 0, 0, False)], [1, 2]),  # which comes back
        (
            [(0, 0, 0, False), (0, 0, 8, False), (0, 2, 0, False), (0, 0, 0, False)],
            [0, 0],
        ),  # clean: never moved
        (
            [(0, 0, 0, True), (0, 0, 8, True), (0, 0, 1, True), (0, 2, 0, True), (0, 0, 0, True)],
            [0, 1],
        ),  # LRU
        ([(0, 0, 0, True), (1, 0, 0, True), (0, 0, 0, True)], [0, 0]),  # two buffers
    ],
)
def test_lines_fetched_and_written_back(accesses, expected):
    assert moved(accesses)[1] == expected


def test_a_released_buffer_is_clear_again():
    cache, _ = moved([(0, 0, 0, True), (0, 0, 8, True), (0, 2, 0, True)])
    release(cache, 0)
    for column in (0, 8, 16):
        access(cache, 0, 0, column % 16, False)
    assert cache.moved.tolist() == [0, 1]


def test_vertices_in_the_history_are_not_stored_again():
    strip = np.array([(0, 1, 2), (2, 1, 3), (2, 3, 4), (9, 10, 11)])
    assert stream_bytes(strip, np.array([0, 3, 4]), np.array([0, 3])).tolist() == [38, 14, 14, 38]
    apart = np.arange(60).reshape(20, 3)
    again = np.concatenate([apart, apart[:1], apart[-1:]])
    assert stream_bytes(again, np.array([0, 22]), np.array([0]))[-2:].tolist() == [
        38,
        2,
    ]  # forgotten, and remembered


def test_triangles_leave_early_when_their_volume_does_not_fit():
    sizes = np.array([30, 10, 10, 10, 50])
    assert popped_early(sizes, np.array([0, 4, 5]), 60).tolist() == [0, 0]
    assert popped_early(sizes, np.array([0, 4, 5]), 59).tolist() == [1, 0]
    assert popped_early(sizes, np.array([0, 4, 5]), 19).tolist() == [3, 0]
