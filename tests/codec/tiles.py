"""Tiles to compress: rounded planes, curved ones, two planes, edges against the background, noise, extremes."""

import numpy as np
from hypothesis import strategies as st

FARTHEST = 2**24 - 1


def rounded(values):
    return np.clip(np.floor(np.asarray(values, float) + 0.5), 0, FARTHEST).astype(np.int64).ravel()


def plane_tile(side, base, dx, dy):
    row, column = np.mgrid[:side, :side]
    return rounded(base + dx * column + dy * row)


SLOPES = st.one_of(st.floats(-3, 3), st.floats(-20000, 20000), st.floats(-2e6, 2e6))
BASES = st.one_of(st.floats(0, 2**24 - 1), st.sampled_from([0.0, 0.5, float(FARTHEST)]))


@st.composite
def planes(draw, side):
    return plane_tile(side, draw(BASES), draw(SLOPES), draw(SLOPES))


@st.composite
def curved(draw, side):
    row, column = np.mgrid[:side, :side]
    slope, bend = draw(SLOPES), draw(st.floats(-500, 500))
    return rounded(draw(BASES) + draw(SLOPES) * column + slope * row + bend * row * (row - 1) / 2)


@st.composite
def two_planes(draw, side):
    row, column = np.mgrid[:side, :side]
    one, other = draw(planes(side)), draw(st.one_of(planes(side), st.just(np.full(side * side, FARTHEST))))
    a, b, c = draw(st.floats(-1, 1)), draw(st.floats(-1, 1)), draw(st.floats(-4, 4))
    return np.where((a * column + b * row + c > 0).ravel(), one, other)


@st.composite
def noisy(draw, side):
    noise = draw(st.lists(st.integers(-3, 3), min_size=side * side, max_size=side * side))
    return np.clip(draw(planes(side)) + np.array(noise), 0, FARTHEST)


def anything(side):
    samples = st.one_of(st.integers(0, FARTHEST), st.sampled_from([0, 1, FARTHEST - 1, FARTHEST]))
    return st.lists(samples, min_size=side * side, max_size=side * side).map(
        lambda values: np.array(values, np.int64)
    )


def tiles(side):
    return st.one_of(planes(side), curved(side), two_planes(side), noisy(side), anything(side))
