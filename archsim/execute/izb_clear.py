"""Before the build phase: `kernels/izb_clear.s` over stencil and heads, which the paper leaves out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from archsim.execute.interpreter import execute
from archsim.execute.izb_memory import NODE, WORD, IzbMemory
from archsim.isa.assembler import load_kernel
from archsim.shadow.grid import Grid
from archsim.trace.records import Tasks
from archsim.trace.stream import Work, chunked

ELEMENTS = 64  # of 16 bytes that a task clears


def clear_work(memory: IzbMemory, grid: Grid) -> Work:
    """One task for each KiB; stencil first."""
    attribute = attributes(memory, grid)
    return chunked(len(attribute), _execute(memory, attribute))


def _execute(memory: IzbMemory, attribute: np.ndarray) -> Iterator[Tasks]:
    constant = np.zeros((256, 4), np.float32)
    constant[0, :2] = 1
    yield execute(load_kernel("izb_clear"), attribute, constant, memory.windows, memory.words).tasks


def attributes(memory: IzbMemory, grid: Grid) -> np.ndarray:
    """float32 [tasks, 1, 4]: v[0] of the kernel."""
    runs = []
    sizes = grid.num_logical_cells * WORD, grid.num_physical_cells * memory.storage.head_bytes
    for window, num_bytes in enumerate(sizes):
        num_elements = -(-num_bytes // NODE)
        for first in range(0, num_elements, ELEMENTS):
            runs.append((-min(ELEMENTS, num_elements - first), first, 0, window))
    return np.array(runs, np.float32)[:, None]
