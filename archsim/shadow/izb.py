"""The irregular z-buffer as a plain algorithm. [Johnson04] sec. 2, 4 and 5

It works in the same float32 arithmetic, on the same constants and in the same order as the kernels in
`kernels/izb_*.s`, so that their results must be equal to its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.raster.conservative import GridFragments
from archsim.shadow.grid import Grid, head_of_logical
from archsim.shadow.occluders import Occluders
from archsim.shadow.pixel_tiles import PixelTiles
from archsim.shadow.transform import LightTransform

NO_NODE = -1


class Samples(NamedTuple):
    """Samples of a light view, in tile order; NaN for pixels that have none."""

    position: np.ndarray  # float32 [n, 3]: x and y in logical cells, depth
    cell: np.ndarray  # int32 [n, 2]: logical cell i, j; -1 where there is no sample


class GridOfLists(NamedTuple):
    """Samples in linked lists, one for each physical cell; a list's head is the sample inserted last."""

    head: np.ndarray  # int32 [num_physical_cells] sample, or NO_NODE; indexed by head_index
    following: np.ndarray  # int32 [n] next sample of the same list, or NO_NODE
    stencil: np.ndarray  # bool [logical rows, logical columns]


class Fragments(NamedTuple):
    """Framebuffer fragments in the order of emission."""

    starts: np.ndarray  # int64 [num_grid_fragments + 1]
    sample: np.ndarray  # int32 [n]
    depth: np.ndarray  # float32 [n]


class ZTest(NamedTuple):
    """What the z-test unit leaves behind."""

    nearest: np.ndarray  # float32 [num_samples] smallest depth seen, initially the sample's own
    num_passed: int


def place_samples(tiles: PixelTiles, transform: LightTransform) -> Samples:
    """Light-space position and logical cell of every pixel's sample."""
    position = np.empty((tiles.reciprocal_depth.size, 3), np.float32)
    _place(tiles.reciprocal_depth, tiles.origins, transform, position)
    cell = np.floor(np.nan_to_num(position[:, :2], nan=-1.0)).astype(np.int32)
    return Samples(position, cell)


@njit
def _place(reciprocal_depth, origins, transform, position):
    """The arithmetic of `izb_build.s`, operation by operation in float32."""
    num_tiles, num_pairs, _ = reciprocal_depth.shape
    for tile in range(num_tiles):
        for pair in range(num_pairs):
            for side in range(2):
                depth = reciprocal_depth[tile, pair, side]
                x = _lane(transform, origins[tile], pair, side, depth, 0)
                y = _lane(transform, origins[tile], pair, side, depth, 1)
                w = _lane(transform, origins[tile], pair, side, depth, 3)
                scale = np.float32(1.0) / w
                index = (tile * num_pairs + pair) * 2 + side
                position[index, 0] = x * scale
                position[index, 1] = y * scale
                position[index, 2] = _lane(transform, origins[tile], pair, side, depth, 2) * scale


@njit
def _lane(transform, origin, pair, side, depth, lane):
    """One component of the homogeneous logical position."""
    value = origin[0] * transform.step_x[lane]
    value = origin[1] * transform.step_y[lane] + value
    value = value + transform.pair[pair, lane]
    if side == 1:
        value = value + transform.step_x[lane]
    return depth * transform.depth[lane] + value


@njit
def build(samples, grid, order):
    """Prepend every sample to its cell's list, in the given order of samples."""
    head = np.full(grid.physical_width * grid.physical_height, NO_NODE, np.int32)
    following = np.full(len(samples.cell), NO_NODE, np.int32)
    stencil = np.zeros((grid.logical_height, grid.logical_width), np.bool_)
    for sample in order:
        i, j = samples.cell[sample]
        if i < 0:
            continue
        cell = head_of_logical(grid, i, j)
        following[sample] = head[cell]
        head[cell] = sample
        stencil[j, i] = True
    return GridOfLists(head, following, stencil)


def rasterize(
    samples: Samples, lists: GridOfLists, grid: Grid, occluders: Occluders, grid_fragments: GridFragments
) -> Fragments:
    """Framebuffer fragments: every sample of a fragment's list that lies inside the triangle, in list order."""
    counts = hit_counts(samples, lists, grid, occluders, grid_fragments)
    starts = np.concatenate([np.zeros(1, np.int64), np.cumsum(counts)])
    sample = np.empty(starts[-1], np.int32)
    depth = np.empty(starts[-1], np.float32)
    _fill(samples, lists, grid, occluders, grid_fragments, (starts, sample, depth))
    return Fragments(starts, sample, depth)


@njit
def hit_counts(samples, lists, grid, occluders, fragments):
    """int64 [num_grid_fragments] samples of each fragment's list that lie inside its triangle."""
    counts = np.zeros(len(fragments.i), np.int64)
    for index in range(len(fragments.i)):
        edges = occluders.edges[fragments.setup_index[index]]
        sample = lists.head[head_of_logical(grid, fragments.i[index], fragments.j[index])]
        while sample != NO_NODE:
            counts[index] += inside(edges, samples.position[sample])
            sample = lists.following[sample]
    return counts


@njit
def _fill(samples, lists, grid, occluders, fragments, out):
    starts, out_sample, out_depth = out
    for index in range(len(fragments.i)):
        triangle = fragments.setup_index[index]
        sample = lists.head[head_of_logical(grid, fragments.i[index], fragments.j[index])]
        slot = starts[index]
        while sample != NO_NODE:
            if inside(occluders.edges[triangle], samples.position[sample]):
                out_sample[slot] = sample
                out_depth[slot] = plane_at(occluders.depth[triangle], samples.position[sample])
                slot += 1
            sample = lists.following[sample]


@njit
def node_visits(lists, grid, fragments):
    """List nodes that the fragments walk over, all together."""
    length = np.zeros(len(lists.head), np.int64)
    for cell in range(len(lists.head)):
        sample = lists.head[cell]
        while sample != NO_NODE:
            length[cell] += 1
            sample = lists.following[sample]
    total = 0
    for index in range(len(fragments.i)):
        total += length[head_of_logical(grid, fragments.i[index], fragments.j[index])]
    return total


@njit
def plane_at(plane, position):
    """a x + b y + 0 z + d in the order of DPH, float32."""
    value = position[0] * plane[0] + position[1] * plane[1]
    value = value + position[2] * plane[2]
    return value + plane[3]


@njit
def inside(edges, position):
    """Whether a sample is on the inner side of, or on, all three edges."""
    for k in range(3):
        if plane_at(edges[k], position) < 0:
            return False
    return True


def z_test(samples: Samples) -> ZTest:
    """The z-buffer before the raster phase: every sample at its own depth, since nothing behind it matters."""
    return ZTest(np.nan_to_num(samples.position[:, 2]), 0)


def z_test_fragments(state: ZTest, sample: np.ndarray, depth: np.ndarray) -> ZTest:
    """Read, compare, replace for fragments in order; `nearest` is updated in place."""
    return ZTest(state.nearest, state.num_passed + _z_test(state.nearest, sample, depth))


@njit
def _z_test(nearest, sample, depth):
    num_passed = 0
    for index in range(len(sample)):
        if depth[index] < nearest[sample[index]]:
            nearest[sample[index]] = depth[index]
            num_passed += 1
    return num_passed


def in_shadow(state: ZTest, samples: Samples) -> np.ndarray:
    """bool [n]: something was nearer to the light than the sample."""
    return state.nearest < np.nan_to_num(samples.position[:, 2])


@njit
def in_shadow_brute_force(samples, occluders):
    """bool [n]: every sample against every triangle in the same arithmetic, without any grid."""
    shadow = np.zeros(len(samples.position), np.bool_)
    for sample in range(len(samples.position)):
        position = samples.position[sample]
        for triangle in range(len(occluders.edges)):
            if inside(occluders.edges[triangle], position):
                shadow[sample] |= plane_at(occluders.depth[triangle], position) < position[2]
    return shadow
