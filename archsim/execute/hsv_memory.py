"""Where the buffers of hierarchical shadow volumes lie in memory for the kernels of both stages.

Window B0: PSV buffers, two words for each block of 2 x 2 tiles: the stencil value of its sample, and eight bits.
Window B1: low-resolution stencil buffer, eight words a block: Smin + Smax of its tiles, then FS of its tiles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.execute.memory import WORD_BYTES, Window, new_memory
from archsim.shadow_volumes.hierarchical import LIT, MIXED, SHADOWED
from archsim.shadow_volumes.psv_cache import block_grid
from archsim.shadow_volumes.tiles import Screen

ENTRY_WORDS = 2  # of a PSV buffer
BLOCK_WORDS = 8  # of the low-resolution stencil buffer
TILES = 4  # of a block
MET = 16  # the first of four bits: Stage 2 has met the tile in this volume
_STATES = np.array([LIT, MIXED, SHADOWED], np.uint8)  # by Smin + Smax


class HsvMemory(NamedTuple):
    """The kernels' memory."""

    words: np.ndarray  # float32 [num_words]
    windows: tuple[Window, Window]
    block_rows: int
    block_columns: int
    num_buffers: int

    @property
    def num_blocks(self) -> int:
        return self.block_rows * self.block_columns

    @property
    def num_bytes(self) -> int:
        """From address 0."""
        return self.windows[1].base + self.windows[1].size


def lay_out(screen: Screen, num_buffers: int) -> HsvMemory:
    """Zeroed memory: every PSV buffer clear, every tile lit."""
    rows, columns = block_grid(screen)
    sizes = [
        _power_of_two(WORD_BYTES * (rows * columns * words + 4))  # and a guard element
        for words in (ENTRY_WORDS * num_buffers, BLOCK_WORDS)
    ]
    base = max(sizes)  # a multiple of the second window's size, behind the first
    windows = Window(0, sizes[0]), Window(base, sizes[1])
    return HsvMemory(new_memory(base + sizes[1]), windows, rows, columns, num_buffers)


def classification(memory: HsvMemory, buffer: int, screen: Screen) -> tuple[np.ndarray, np.ndarray]:
    """(boundary bool [num_tiles], stencil value int64 [block rows, block columns]) of a PSV buffer."""
    first = buffer * memory.num_blocks * ENTRY_WORDS
    entries = memory.words[first : first + memory.num_blocks * ENTRY_WORDS].reshape(-1, ENTRY_WORDS)
    bits = entries[:, 1].astype(np.int64)[:, None] >> np.arange(TILES) & 1
    stencil = entries[:, 0].astype(np.int64).reshape(memory.block_rows, memory.block_columns)
    return _by_tile(memory, bits != 0, screen), stencil


def tile_states(memory: HsvMemory, screen: Screen) -> np.ndarray:
    """uint8 [num_tiles] LIT, SHADOWED or MIXED."""
    return _by_tile(memory, _STATES[_low_resolution(memory)[:, 0].astype(np.int64)], screen)


def set_tile_states(memory: HsvMemory, tiles: np.ndarray, states: np.ndarray, screen: Screen) -> None:
    """Bring Smin and Smax of some tiles up to date, as the unit that draws their pixels does."""
    row, column = tiles // screen.columns, tiles % screen.columns
    block = row // 2 * memory.block_columns + column // 2
    _low_resolution(memory)[block, 0, 2 * (column % 2) + row % 2] = np.argsort(_STATES)[states]


def _low_resolution(memory: HsvMemory) -> np.ndarray:
    """float32 [num_blocks, 2, TILES], a view of the memory: Smin + Smax, FS."""
    first = memory.windows[1].base // WORD_BYTES
    return memory.words[first : first + memory.num_blocks * BLOCK_WORDS].reshape(-1, 2, TILES)


def _by_tile(memory: HsvMemory, by_block: np.ndarray, screen: Screen) -> np.ndarray:
    """[num_tiles] in rows, from [num_blocks, TILES] whose tiles stand column by column."""
    blocks = by_block.reshape(memory.block_rows, memory.block_columns, 2, 2)
    rows = blocks.transpose(0, 3, 1, 2).reshape(2 * memory.block_rows, 2 * memory.block_columns)
    return rows[: screen.rows, : screen.columns].reshape(-1)


def _power_of_two(size: int) -> int:
    return 1 << (size - 1).bit_length()
