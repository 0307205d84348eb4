"""Histograms and maps of an irregular shadow map, for its report."""

from __future__ import annotations

import numpy as np

from archsim.run.result import Histogram
from archsim.shadow.grid import Grid, physical_cell
from archsim.shadow.plain import Outcome


def list_histogram(outcomes: list[Outcome], grid: Grid) -> Histogram:
    """Physical cells by the length of their list, over all light views."""
    lengths = [_list_lengths(outcome, grid) for outcome in outcomes]
    counts = np.bincount(np.concatenate(lengths)) if lengths else np.zeros(1, np.int64)
    return Histogram("Length of the physical cells' lists", "samples", "cells", counts)


def fragment_histogram(outcomes: list[Outcome]) -> Histogram:
    """Samples by the number of triangles that cover them, over all light views."""
    fragments = [fragments_of_samples(outcome)[_placed(outcome)] for outcome in outcomes]
    counts = np.bincount(np.concatenate(fragments)) if fragments else np.zeros(1, np.int64)
    return Histogram("Triangles that cover a sample, seen from the light", "triangles", "samples", counts)


def fragments_of_samples(outcome: Outcome) -> np.ndarray:
    """int32 [num_samples] framebuffer fragments of each sample."""
    return np.bincount(outcome.fragments.sample, minlength=len(outcome.samples.cell)).astype(np.int32)


def visits_of_samples(outcome: Outcome, grid: Grid) -> np.ndarray:
    """int64 [num_samples] grid fragments whose list the sample is in: so often its node is visited."""
    fragments, visits = outcome.grid_fragments, np.zeros(len(outcome.samples.cell), np.int64)
    fragments_of_list = np.bincount(
        _list_of(grid, np.stack([fragments.i, fragments.j], axis=1)), minlength=grid.num_physical_cells
    )
    visits[_placed(outcome)] = fragments_of_list[_list_of(grid, outcome.samples.cell[_placed(outcome)])]
    return visits


def cell_map(outcome: Outcome, grid: Grid) -> np.ndarray:
    """float32 [logical rows, logical columns] samples in each logical cell, NaN where there are none."""
    cell = outcome.samples.cell[_placed(outcome)]
    flat = np.bincount(cell[:, 1] * grid.logical_width + cell[:, 0], minlength=grid.num_logical_cells)
    image = flat.reshape(grid.logical_height, grid.logical_width).astype(np.float32)
    return np.where(image > 0, image, np.float32(np.nan))


def _placed(outcome: Outcome) -> np.ndarray:
    """bool [num_samples]: the pixel has a sample in this light view."""
    return outcome.samples.cell[:, 0] >= 0


def _list_lengths(outcome: Outcome, grid: Grid) -> np.ndarray:
    """int64 [num_physical_cells] samples in each list."""
    lists = _list_of(grid, outcome.samples.cell[_placed(outcome)])
    return np.bincount(lists, minlength=grid.num_physical_cells)


def _list_of(grid: Grid, cells: np.ndarray) -> np.ndarray:
    """int64 [n] number of the physical cell of logical cells [n, 2]."""
    physical_i, physical_j = physical_cell(grid, cells[:, 0].astype(np.int64), cells[:, 1].astype(np.int64))
    return np.asarray(physical_j * grid.physical_width + physical_i)
