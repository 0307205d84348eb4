"""Where the irregular z-buffer's arrays lie in memory, and how the two kernels are told.

Window B0: stencil (4 bytes a logical cell), then reciprocal eye depths (8 bytes a pixel pair).
Window B1: list heads (4 bytes a physical cell), then list nodes (16 bytes a sample: x, y, depth, next).
Both end with a guard element that holds no data. A list head or `next` is a node index in B1, 0 ends a list.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.execute.memory import Window, new_memory
from archsim.shadow.grid import Grid
from archsim.shadow.pixel_tiles import PixelTiles

WORD, PAIR, NODE = 4, 8, 16  # bytes
MAX_INDEX = 2**24  # integers that a float32 register holds exactly


class IzbMemory(NamedTuple):
    """Memory of one light view: the words, the two windows, and the first index of the second array of each."""

    words: np.ndarray  # float32 [(B1.base + B1.size) / 4]
    windows: tuple[Window, Window]
    first_pair: int  # pair index in B0 of the first depth pair
    first_node: int  # node index in B1 of the first sample


def lay_out(grid: Grid, tiles: PixelTiles) -> IzbMemory:
    """Memory with cleared heads and stencil and with the depths of `tiles` in place.

    Clearing costs are not part of the build phase ([Johnson04] sec. 6).
    """
    first_pair = _ceil_div(grid.num_logical_cells * WORD, PAIR)
    first_node = max(1, _ceil_div(grid.num_physical_cells * WORD, NODE))
    num_pixels = tiles.reciprocal_depth.size
    if max(first_node + num_pixels, first_pair * 2, grid.num_logical_cells) >= MAX_INDEX:
        raise fail(
            f"{num_pixels} samples and {grid.num_logical_cells} logical cells need node numbers beyond 2^24"
        )
    size_0 = _power_of_two((first_pair + num_pixels // 2) * PAIR + NODE)
    size_1 = _power_of_two((first_node + num_pixels) * NODE + NODE)
    base_1 = _ceil_div(size_0, size_1) * size_1
    words = new_memory(base_1 + size_1)
    start = first_pair * PAIR // WORD
    words[start : start + num_pixels] = tiles.reciprocal_depth.ravel()
    return IzbMemory(words, (Window(0, size_0), Window(base_1, size_1)), first_pair, first_node)


def heads(memory: IzbMemory, grid: Grid) -> np.ndarray:
    """int32 [num_physical_cells] sample at the head of each list, -1 for none."""
    start = memory.windows[1].base // WORD
    return _as_samples(memory, memory.words[start : start + grid.num_physical_cells])


def nodes(memory: IzbMemory, num_samples: int) -> np.ndarray:
    """float32 [num_samples, 4] list nodes as they lie in memory (a view)."""
    start = (memory.windows[1].base + memory.first_node * NODE) // WORD
    return memory.words[start : start + num_samples * 4].reshape(num_samples, 4)


def following(memory: IzbMemory, num_samples: int) -> np.ndarray:
    """int32 [num_samples] next sample in each node's list, -1 for none."""
    return _as_samples(memory, nodes(memory, num_samples)[:, 3])


def stencil(memory: IzbMemory, grid: Grid) -> np.ndarray:
    """bool [logical rows, logical columns] marked cells."""
    return memory.words[: grid.num_logical_cells].reshape(grid.logical_height, grid.logical_width) != 0


def _as_samples(memory: IzbMemory, pointers: np.ndarray) -> np.ndarray:
    return np.where(pointers > 0, pointers - memory.first_node, -1).astype(np.int32)


def _ceil_div(a: int, b: int) -> int:
    return -(-a // b)


def _power_of_two(size: int) -> int:
    return 1 << (size - 1).bit_length()
