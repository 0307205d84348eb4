"""Drawing: depths by hand, logarithmic maps against linear ones, clipping, clamping, counts."""

import numpy as np
import pytest

from archsim.lograster.depth_buffer import FARTHEST, draw
from archsim.lograster.grid import make_grid
from archsim.lograster.offset import OffsetSpec, Switch
from archsim.lograster.parameterization import log_unwarp

SQUARE = np.array([(0, 1, 2), (0, 2, 3)], np.int32)


def square(*depths, low=0.0, high=1.0):
    """A square of the map with depths at its corners, w = 1."""
    places = [(low, low), (high, low), (high, high), (low, high)]
    return np.array([(x, y, z, 1.0) for (x, y), z in zip(places, depths, strict=True)])


def test_a_slope_in_x_by_hand():
    drawn = draw(square(0, 1, 1, 0), SQUARE, make_grid(4, 4))

    expected = np.array([1, 3, 5, 7]) / 8 * FARTHEST
    assert np.array_equal(drawn.depth, np.tile(np.floor(expected + 0.5), (4, 1)))


@pytest.mark.parametrize("ratio", [2.0, 1000.0])
def test_a_slope_in_y_is_curved_by_the_logarithm(ratio):
    drawn = draw(square(0, 0, 1, 1), SQUARE, make_grid(4, 64, ratio))

    expected = log_unwarp((np.arange(64) + 0.5) / 64, ratio) * FARTHEST
    assert np.abs(drawn.depth[:, 0] - expected).max() <= 1.5  # coordinates and depths both have 24 bits


def test_the_nearest_wins_whatever_the_order():
    near, far = square(0.25, 0.25, 0.25, 0.25), square(0.5, 0.5, 0.5, 0.5)
    both = np.concatenate([near, far])

    one = draw(both, np.concatenate([SQUARE, SQUARE + 4]), make_grid(8, 8))
    other = draw(both, np.concatenate([SQUARE + 4, SQUARE]), make_grid(8, 8))

    assert np.array_equal(one.depth, other.depth)
    assert (one.counts.fragments, one.counts.passed, other.counts.passed) == (128, 64, 128)


def test_samples_are_counted_by_their_fragments():
    """A square over all of 8 x 8 samples, another over 4 x 4 of them."""
    both = np.concatenate([square(0.25, 0.25, 0.25, 0.25), square(0.5, 0.5, 0.5, 0.5, high=0.5)])

    drawn = draw(both, np.concatenate([SQUARE, SQUARE + 4]), make_grid(8, 8))

    assert drawn.layers.tolist() == [0, 64 - 16, 16]


def test_only_tiles_with_a_passing_sample_are_touched():
    drawn = draw(square(0.5, 0.5, 0.5, 0.5, low=0.3, high=0.45), SQUARE, make_grid(16, 16))

    assert drawn.touched.sum() == 1
    assert drawn.touched[1, 1]
    assert drawn.depth[drawn.depth < FARTHEST].size == drawn.counts.passed == 4  # columns and rows 5 and 6


def test_depths_beyond_the_range_are_clamped():
    nearer = draw(square(-1, -1, -1, -1), SQUARE, make_grid(4, 4))
    beyond = draw(square(2, 2, 2, 2), SQUARE, make_grid(4, 4))

    assert (nearer.depth == 0).all()
    assert nearer.touched.all()
    assert (beyond.depth == FARTHEST).all()
    assert not beyond.touched.any()


def test_what_crosses_w_0_is_drawn_up_to_there():
    """A strip from x/w = 0.5 to infinity and on behind the light."""
    strip = np.array([(0.5, 0.0, 0.25, 1.0), (0.5, 1.0, 0.25, 1.0), (0.5, 0.5, 0.0, -1.0)])
    drawn = draw(strip, np.array([(0, 1, 2)], np.int32), make_grid(8, 8))

    assert (drawn.depth[:, :4] == FARTHEST).all()
    assert (drawn.depth[2:6, 4:6] < FARTHEST).all()


def test_nothing_comes_of_nothing():
    drawn = draw(np.empty((0, 4)), np.empty((0, 3), np.int32), make_grid(8, 8))

    assert not drawn.touched.any()
    assert sum(drawn.counts) == 0


def test_offset_pushes_away_from_the_light():
    plain = draw(square(0, 0.5, 0.5, 0), SQUARE, make_grid(8, 8))
    pushed = draw(
        square(0, 0.5, 0.5, 0), SQUARE, make_grid(8, 8), OffsetSpec(2.0, 0.125, int(Switch.INTERPOLATED))
    )

    expected = (2.0 * 0.5 / 8 + 0.125) * FARTHEST
    assert np.abs(pushed.depth - plain.depth - expected).max() <= 1


@pytest.mark.parametrize("ratio", [10.0, 1000.0])
def test_the_treatments_of_the_switch_differ_only_where_there_is_one(ratio):
    grid = make_grid(32, 32, ratio)
    steep = square(0.1, 0.3, 0.8, 0.6)  # its slope along y falls below the slope across somewhere
    drawn = {s: draw(steep, SQUARE, grid, OffsetSpec(1.0, 0.0, int(s))) for s in Switch}

    assert drawn[Switch.SPLIT].counts.switches == 2
    assert np.array_equal(drawn[Switch.SPLIT].depth, drawn[Switch.TWO_PLANES].depth)
    difference = drawn[Switch.INTERPOLATED].depth - drawn[Switch.SPLIT].depth
    assert difference.min() >= -1
    assert difference.max() > 100


def test_equal_corners_give_equal_bytes_in_every_order_of_corners():
    random = np.random.default_rng(1)
    vertices = np.concatenate([random.uniform(-0.5, 1.5, (30, 3)), np.ones((30, 1))], axis=1)
    triangles = random.integers(0, 30, (20, 3)).astype(np.int32)
    covered = [
        draw(vertices, triangles[:, order], make_grid(32, 32, 50.0)) for order in ([0, 1, 2], [2, 1, 0])
    ]

    assert covered[0].counts.fragments == covered[1].counts.fragments
    assert np.abs(covered[0].depth - covered[1].depth).max() <= 1
