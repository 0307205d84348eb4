"""Where the irregular z-buffer's arrays lie in memory, and how the two kernels are told.

Window B0: stencil (4 bytes a logical cell), then reciprocal eye depths (8 bytes a pixel pair).
Window B1: list heads (4 bytes a physical cell), then list nodes (16 bytes a sample: x, y, depth, next).
A head may take a whole 16 bytes, as it must where loads and stores have 128 bits only ([Johnson04] sec. 6): the kernels
number heads by words in any case, and `spread_heads` moves them apart in what is played.
Both end with a guard element that holds no data. A list head or `next` is a node index in B1, 0 ends a list.
With a k-d tree in each cell, heads are roots and nodes are x, y and two links (kernels/izb_build_kd.s).

Depths lie row by row of the image or pixel tile by pixel tile. A sample's node lies at its pixel's place, or in a pool:
the threads, in step, each take the next two nodes for their next two pixels, so that neighbours in memory belong to
different tiles.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.execute.memory import Window, new_memory
from archsim.isa.program import NUM_LOCKS
from archsim.shadow.grid import Grid
from archsim.shadow.pixel_tiles import PixelTiles, image_order
from archsim.trace.records import Op, Tasks

WORD, PAIR, NODE = 4, 8, 16  # bytes
MAX_INDEX = 2**24  # integers that a float32 register holds exactly


class Structure(IntEnum):
    """What holds the samples of a grid cell."""

    LIST = 0
    KD_TREE = 1


class Storage(NamedTuple):
    """Choices that change addresses and locks, but no picture."""

    structure: int = Structure.LIST
    num_locks: int = NUM_LOCKS  # of those on the chip, how many the build kernel uses
    pool_threads: int = 0  # threads that take nodes from one pool; 0: a node lies at its pixel's place
    by_tiles: bool = False  # pixels lie tile by tile instead of row by row of the image
    head_bytes: int = WORD  # from one list head to the next: WORD or NODE


LISTS = Storage()


class IzbMemory(NamedTuple):
    """Memory of one light view: the words, the two windows, and the first index of the second array of each."""

    words: np.ndarray  # float32 [(B1.base + B1.size) / 4]
    windows: tuple[Window, Window]
    first_pair: int  # pair index in B0 of the first depth pair
    first_node: int  # node index in B1 of the first node
    storage: Storage
    place_of_pixel: np.ndarray  # int32 [num_samples] place of a pixel's depth, counted from first_pair * 2
    node_of_sample: np.ndarray  # int32 [num_samples] number of its node, counted from first_node
    sample_of_node: np.ndarray  # int32 [num_nodes]


def lay_out(grid: Grid, tiles: PixelTiles, order: np.ndarray, storage: Storage = LISTS) -> IzbMemory:
    """Memory with cleared heads and stencil and with the depths of `tiles` in place; tiles are built in `order`.

    Clearing costs are not part of the build phase ([Johnson04] sec. 6); `izb_clear.py` has them.
    """
    number = np.arange(tiles.reciprocal_depth.size, dtype=np.int32)
    place = number if storage.by_tiles else image_order(tiles)
    node_of_sample, sample_of_node = place, np.argsort(place).astype(np.int32)
    if storage.pool_threads:
        node_of_sample, sample_of_node = _from_pool(tiles, order, storage.pool_threads)
    first_pair = _ceil_div(grid.num_logical_cells * WORD, NODE) * NODE // PAIR
    first_node = max(1, _ceil_div(grid.num_physical_cells * storage.head_bytes, NODE))
    num_pixels = tiles.reciprocal_depth.size
    num_nodes = len(sample_of_node)
    largest_node = (first_node + num_nodes) * (NODE // WORD if storage.structure == Structure.KD_TREE else 1)
    if max(largest_node, first_pair * 2, grid.num_logical_cells) >= MAX_INDEX:
        raise fail(
            f"{num_pixels} samples and {grid.num_logical_cells} logical cells need node numbers beyond 2^24"
        )
    size_0 = _power_of_two((first_pair + num_pixels // 2) * PAIR + NODE)
    size_1 = _power_of_two((first_node + num_nodes) * NODE + NODE)
    base_1 = _ceil_div(size_0, size_1) * size_1
    words = new_memory(base_1 + size_1)
    start = first_pair * PAIR // WORD
    words[start + place] = tiles.reciprocal_depth.ravel()
    windows = (Window(0, size_0), Window(base_1, size_1))
    return IzbMemory(words, windows, first_pair, first_node, storage, place, node_of_sample, sample_of_node)


def _from_pool(tiles: PixelTiles, order: np.ndarray, pool_threads: int) -> tuple[np.ndarray, np.ndarray]:
    """Node of each sample, and sample of each node."""
    per_tile = tiles.num_pairs * 2
    turn, thread = np.divmod(np.arange(len(order)), pool_threads)
    pair = turn[:, None] * tiles.num_pairs + np.arange(tiles.num_pairs)
    first = (pair * pool_threads + thread[:, None]) * 2
    nodes = np.stack([first, first + 1], axis=-1).reshape(len(order), per_tile)
    samples = order[:, None] * per_tile + np.arange(per_tile)
    node_of_sample = np.zeros(tiles.reciprocal_depth.size, np.int32)
    node_of_sample[samples] = nodes
    sample_of_node = np.zeros(-(-len(order) // pool_threads) * pool_threads * per_tile, np.int32)
    sample_of_node[nodes] = samples
    return node_of_sample, sample_of_node


def spread_heads(memory: IzbMemory, grid: Grid, tasks: Tasks) -> None:
    """Give the accesses to list heads the addresses and the width that heads of `head_bytes` have; in place."""
    if memory.storage.head_bytes == WORD:
        return
    records, base = tasks.records, memory.windows[1].base
    index = (records["address"] - base) // WORD
    access = (records["op"] == Op.LOAD) | (records["op"] == Op.STORE)
    head = np.flatnonzero(access & (index >= 0) & (index < grid.num_physical_cells))
    records["address"][head] = base + index[head] * memory.storage.head_bytes
    records["bytes"][head] = memory.storage.head_bytes


def heads(memory: IzbMemory, grid: Grid) -> np.ndarray:
    """int32 [num_physical_cells] sample at the head of each list, -1 for none."""
    start = memory.windows[1].base // WORD
    return _as_samples(memory, memory.words[start : start + grid.num_physical_cells])


def nodes(memory: IzbMemory) -> np.ndarray:
    """float32 [num_samples, 4] the nodes of the samples."""
    start = (memory.windows[1].base + memory.first_node * NODE) // WORD
    stored = memory.words[start : start + len(memory.sample_of_node) * 4].reshape(-1, 4)
    return stored[memory.node_of_sample]


def following(memory: IzbMemory) -> np.ndarray:
    """int32 [num_samples] next sample in each node's list, -1 for none."""
    return _as_samples(memory, nodes(memory)[:, 3])


def samples_of(memory: IzbMemory, node_index: np.ndarray) -> np.ndarray:
    """int32 samples of nodes that are given by their index in B1."""
    return memory.sample_of_node[node_index - memory.first_node]


def stencil(memory: IzbMemory, grid: Grid) -> np.ndarray:
    """bool [logical rows, logical columns] marked cells."""
    return memory.words[: grid.num_logical_cells].reshape(grid.logical_height, grid.logical_width) != 0


def _as_samples(memory: IzbMemory, pointers: np.ndarray) -> np.ndarray:
    node = np.where(pointers > 0, pointers - memory.first_node, 0).astype(np.int64)
    return np.where(pointers > 0, memory.sample_of_node[node], -1).astype(np.int32)


def _ceil_div(a: int, b: int) -> int:
    return -(-a // b)


def _power_of_two(size: int) -> int:
    return 1 << (size - 1).bit_length()
