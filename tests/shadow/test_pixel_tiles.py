"""Cutting an image into tiles and putting it together again."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from archsim.shadow.pixel_tiles import cut, image_order, populated_tiles, untile

sizes = st.integers(1, 20)
tiles = st.tuples(st.integers(1, 4).map(lambda k: 2 * k), st.integers(1, 6))


@given(sizes, sizes, tiles)
def test_round_trip(height, width, tile):
    image = np.arange(1, height * width + 1, dtype=np.float32).reshape(height, width)
    cut_up = cut(image, np.ones_like(image, np.bool_), tile)
    values = cut_up.reciprocal_depth.ravel()
    np.testing.assert_array_equal(untile(cut_up, values, height, width), image)
    np.testing.assert_array_equal(np.isnan(values), cut_up.pixel < 0)


def test_order_by_hand():
    image = np.arange(24, dtype=np.float32).reshape(4, 6)
    found = cut(image, np.ones_like(image, np.bool_), (4, 2))
    assert found.pixel[:8].tolist() == [0, 1, 2, 3, 6, 7, 8, 9]
    assert found.pixel[8:16].tolist() == [4, 5, -1, -1, 10, 11, -1, -1]
    assert found.origins.tolist() == [[0, 0], [4, 0], [0, 2], [4, 2]]


def test_image_order_by_hand():
    image = np.ones((3, 6), np.float32)  # padded to 4 x 8
    found = image_order(cut(image, np.ones_like(image, np.bool_), (4, 2)))
    assert found[:16].tolist() == [0, 1, 2, 3, 8, 9, 10, 11, 4, 5, 6, 7, 12, 13, 14, 15]
    assert found[16:20].tolist() == [16, 17, 18, 19]
    assert sorted(found.tolist()) == list(range(32))


def test_tiles_without_samples_are_not_populated():
    image = np.ones((4, 8), np.float32)
    taken = np.zeros_like(image, np.bool_)
    taken[3, 5] = True
    assert populated_tiles(cut(image, taken, (4, 2))).tolist() == [3]
