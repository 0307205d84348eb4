"""The raster phase: `kernels/izb_raster.s`, or `izb_raster_kd.s`, over grid fragments."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from archsim.execute.interpreter import execute
from archsim.execute.izb_memory import IzbMemory, Structure, samples_of, spread_heads
from archsim.isa.assembler import load_kernel
from archsim.raster.conservative import GridFragments
from archsim.shadow.grid import Grid
from archsim.shadow.occluders import Occluders
from archsim.trace.records import Tasks
from archsim.trace.stream import Work, chunked

KERNELS = {Structure.LIST: "izb_raster", Structure.KD_TREE: "izb_raster_kd"}
CHUNK_TASKS = 1 << 14
_ROUNDING = 2.0**-20 * np.array([-1, -1, 1, 1])  # of float32 edge functions, as part of the grid's size

Output = Callable[[np.ndarray, np.ndarray], None]  # takes samples int64 [n] and depths float32 [n]


def raster_work(
    memory: IzbMemory, grid: Grid, occluders: Occluders, fragments: GridFragments, output: Output
) -> Work:
    """One task for each grid fragment; framebuffer fragments go to `output` as the work is drawn, in task order."""
    return chunked(len(fragments.i), _execute(memory, grid, occluders, fragments, output))


def _execute(
    memory: IzbMemory, grid: Grid, occluders: Occluders, fragments: GridFragments, output: Output
) -> Iterator[Tasks]:
    program = load_kernel(KERNELS[Structure(memory.storage.structure)])
    constant = constants(grid)
    for start in range(0, len(fragments.i), CHUNK_TASKS):
        attribute = attributes(grid, occluders, fragments, slice(start, start + CHUNK_TASKS))
        done = execute(program, attribute, constant, memory.windows, memory.words)
        output(samples_of(memory, done.emitted_address), done.emitted_value)
        spread_heads(memory, grid, done.tasks)
        yield done.tasks


def attributes(grid: Grid, occluders: Occluders, fragments: GridFragments, chunk: slice) -> np.ndarray:
    """float32 [tasks, 7, 4]: v[0] ... v[6] of the kernels for some of the fragments."""
    triangle, i, j = fragments.setup_index[chunk], fragments.i[chunk], fragments.j[chunk]
    within = j % grid.tile_height * grid.tile_width + i % grid.tile_width
    attribute = np.zeros((len(i), 7, 4), np.float32)
    attribute[:, 0, 0] = i // grid.tile_width / grid.tiles_wide
    attribute[:, 0, 1] = j // grid.tile_height / grid.tiles_high
    attribute[:, 0, 3] = within / grid.tile_area
    attribute[:, 1:4] = occluders.edges[triangle]
    attribute[:, 4] = occluders.depth[triangle]
    attribute[:, 5, 0] = j / grid.physical_width
    attribute[:, 5, 1] = i / grid.physical_height
    grown = occluders.setup.bounds[triangle] + _ROUNDING * max(grid.logical_width, grid.logical_height)
    attribute[:, 6] = np.clip(grown, -3e38, 3e38)
    return attribute


def constants(grid: Grid) -> np.ndarray:
    """float32 [256, 4]: c[] of the kernel."""
    constant = np.zeros((256, 4), np.float32)
    constant[0, :2] = (1 / grid.tiles_wide, 1 / grid.tiles_high)
    constant[2, :2] = (4, 3)
    constant[1] = (grid.tiles_wide * grid.tile_area, grid.num_physical_cells, 0, grid.tile_area)
    return constant
