"""Triangles of a drawn light view: how large, how many, and how often where samples are, for the wanted fragments."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.raster.conservative import GridFragments, Setup, populated, rasterize
from archsim.shadow import izb
from archsim.shadow.grid import Grid
from archsim.shadow.occluders import Occluders

_STEPS = 12  # of Broyden's method
_SHIFTS = (0.2, -0.1)  # in the logarithm of the leg and in the share, for its slopes
_LONGEST = np.array([1.0, 0.3])  # step in the same
_LOWEST, _HIGHEST = np.array([np.log(0.05), 0.0]), np.array([np.log(4096.0), 1.0])
_CLOSE = 0.002  # relative error of the grid fragments that will do
_MARGIN = 2.0**-10  # cells; above the rounding error of float32 edge functions on any grid
_NEIGHBOUR_CELLS = 16  # triangles in a square of so many cells follow each other

Built = tuple[izb.Samples, izb.GridOfLists]


class Wanted(NamedTuple):
    """Fragments asked for."""

    pre_stencil: int
    post_stencil: int
    hits: int


class _Triangles(NamedTuple):
    """Right-angled triangles with both legs along the axes."""

    corner: np.ndarray  # float64 [n, 2] the right angle, in logical cells
    legs: np.ndarray  # float64 [n, 2] signed
    depth: np.ndarray  # float64 [n]


class _Trial(NamedTuple):
    """As many triangles of one kind as give the wanted hits, and their grid fragments."""

    triangles: _Triangles
    pre_stencil: int
    post_stencil: int


def draw_triangles(wanted: Wanted, grid: Grid, built: Built, neighbours: bool, seed: int) -> Occluders:
    """Triangles with about the wanted fragments: leg and share are sought by Broyden's method from a plain guess.

    A longer leg means fewer grid fragments for the same hits; more triangles on samples, fewer on empty cells.
    """

    def trial_at(place: np.ndarray) -> tuple[_Trial, np.ndarray]:
        trial = _trial(wanted, grid, built, float(np.exp(place[0])), float(place[1]), seed)
        post = trial.post_stencil / wanted.post_stencil
        return trial, np.log([post, trial.pre_stencil / wanted.pre_stencil / post])

    def slopes_at(place: np.ndarray, error: np.ndarray) -> np.ndarray:
        return np.stack(
            [(trial_at(place + shift)[1] - error) / shift.sum() for shift in np.diag(_SHIFTS)], axis=1
        )

    place = np.array([np.log(8.0), 0.5])  # logarithm of the mean leg in cells, share on samples
    best, error = trial_at(place)
    slopes, radius = slopes_at(place, error), 1.0
    for _ in range(_STEPS):
        if np.abs(error).max() < _CLOSE or radius < 0.02:
            break
        step = np.clip(np.linalg.lstsq(slopes, -error, rcond=0.01)[0], -radius * _LONGEST, radius * _LONGEST)
        moved = np.clip(place + step, _LOWEST, _HIGHEST) - place
        trial, found = trial_at(place + moved)
        if np.abs(found).max() < np.abs(error).max():
            slopes = slopes + np.outer(found - error - slopes @ moved, moved) / max(moved @ moved, 1e-12)
            place, best, error, radius = place + moved, trial, found, min(1.0, 2 * radius)
        else:
            slopes, radius = slopes_at(place, error), radius / 3
    return _occluders(_near_each_other(best.triangles) if neighbours else best.triangles)


def _trial(wanted: Wanted, grid: Grid, built: Built, leg: float, share: float, seed: int) -> _Trial:
    """Triangles in the order of drawing until the hits are reached."""
    samples, lists = built
    box = populated(lists.stencil)
    extent = np.zeros_like(lists.stencil)
    extent[box.j0 : box.j1, box.i0 : box.i1] = True
    number = int(1.5 * wanted.pre_stencil / (leg + 1) ** 2) + 16
    while True:
        triangles = _drawn(built, leg, share, number, seed)
        occluders = _occluders(triangles)
        overlapped = rasterize(occluders.setup, extent, (grid.tile_width, grid.tile_height), _MARGIN)
        marked = lists.stencil[overlapped.j, overlapped.i]
        kept = GridFragments(overlapped.setup_index[marked], overlapped.i[marked], overlapped.j[marked], 0)
        hits = izb.hit_counts(samples, lists, grid, occluders, kept)
        total = np.cumsum(np.bincount(kept.setup_index, weights=hits, minlength=number))
        if total[-1] >= wanted.hits or number > wanted.pre_stencil:  # one overlaps a cell at least
            break
        number = 2 * number
    needed = min(int(np.searchsorted(total, wanted.hits)) + 1, number)
    used = _Triangles(*(part[:needed] for part in triangles))
    pre = int((overlapped.setup_index < needed).sum())
    return _Trial(used, pre, max(1, int((kept.setup_index < needed).sum())))


def _drawn(built: Built, leg: float, share: float, number: int, seed: int) -> _Triangles:
    """The first triangles of a stream that the seed alone decides; leg and share only scale it."""
    samples, lists = built
    placed = samples.position[samples.cell[:, 0] >= 0, :2]
    box = populated(lists.stencil)
    uniform = np.random.default_rng([seed, 1]).random((number, 8))
    anywhere = (box.i0, box.j0) + uniform[:, :2] * (box.i1 - box.i0, box.j1 - box.j0)
    on_sample = placed[(uniform[:, 2] * len(placed)).astype(np.int64)]
    middle = np.where((uniform[:, 3] < share)[:, None], on_sample, anywhere)
    signs = np.where(uniform[:, 4:6] < 0.5, -1.0, 1.0)
    legs = signs * (-leg * np.log1p(-uniform[:, 6]))[:, None]
    return _Triangles(middle - legs / 3, legs, uniform[:, 7])


def _near_each_other(triangles: _Triangles) -> _Triangles:
    """The triangles square by square along a Z-order curve, as drawn within a square."""
    square = np.maximum((triangles.corner + triangles.legs / 3) // _NEIGHBOUR_CELLS, 0).astype(np.int64)
    code = sum((square[:, axis] >> bit & 1) << (2 * bit + axis) for axis in (0, 1) for bit in range(12))
    order = np.argsort(code, kind="stable")
    return _Triangles(*(part[order] for part in triangles))


def _occluders(triangles: _Triangles) -> Occluders:
    """Edge functions, largest factor 1: right of one leg, beyond the other, before the hypotenuse."""
    number = len(triangles.depth)
    x, y = triangles.corner.T
    side_x, side_y = np.sign(triangles.legs).T
    edges = np.zeros((number, 3, 3))
    edges[:, 0, 0], edges[:, 0, 2] = side_x, -side_x * x
    edges[:, 1, 1], edges[:, 1, 2] = side_y, -side_y * y
    edges[:, 2, 0], edges[:, 2, 1] = -side_x, -side_y
    edges[:, 2, 2] = np.abs(triangles.legs[:, 0]) + side_x * x + side_y * y
    ends = np.stack([triangles.corner, triangles.corner + triangles.legs])
    bounds = np.concatenate([ends.min(axis=0), ends.max(axis=0)], axis=1)

    attributes = np.zeros((number, 3, 4), np.float32)
    attributes[..., [0, 1, 3]] = edges
    depth = np.zeros((number, 4), np.float32)
    depth[:, 3] = triangles.depth
    return Occluders(Setup(np.arange(number, dtype=np.int32), edges, bounds), attributes, depth)
