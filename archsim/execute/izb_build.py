"""The build phase: `kernels/izb_build.s`, or `izb_build_kd.s`, over tiles of pixels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from archsim.execute.interpreter import execute
from archsim.execute.izb_memory import IzbMemory, Structure, spread_heads
from archsim.isa.assembler import load_kernel
from archsim.shadow.grid import Grid
from archsim.shadow.pixel_tiles import PixelTiles, populated_tiles
from archsim.shadow.transform import LightTransform
from archsim.trace.records import Op, Tasks
from archsim.trace.stream import Work, chunked

KERNELS = {Structure.LIST: "izb_build", Structure.KD_TREE: "izb_build_kd"}
CHUNK_TASKS = 1024
LAST_CONSTANT = 255  # behind the positions of the pairs
LAST_STEP = 133  # behind the steps from pair to pair


def build_work(
    memory: IzbMemory, grid: Grid, tiles: PixelTiles, transform: LightTransform, order: np.ndarray
) -> Work:
    """One task for each tile in `order`. The lists are in memory when the work has been drawn to its end."""
    constant = constants(memory, grid, tiles, transform)
    return chunked(len(order), _execute(memory, grid, constant, attributes(memory, tiles)[order]))


def _execute(memory: IzbMemory, grid: Grid, constant: np.ndarray, attribute: np.ndarray) -> Iterator[Tasks]:
    program = load_kernel(KERNELS[Structure(memory.storage.structure)])
    for start in range(0, len(attribute), CHUNK_TASKS):
        chunk = attribute[start : start + CHUNK_TASKS]
        tasks = execute(program, chunk, constant, memory.windows, memory.words).tasks
        _share_locks(tasks, memory.storage.num_locks)
        spread_heads(memory, grid, tasks)
        yield tasks


def _share_locks(tasks: Tasks, num_locks: int) -> None:
    """Let the kernel's locks, of which a task holds one at a time, stand for fewer: number modulo `num_locks`."""
    records = tasks.records
    locking = (records["op"] == Op.LOCK) | (records["op"] == Op.UNLOCK)
    records["address"] = np.where(locking, records["address"] % num_locks, records["address"])


def tile_order(tiles: PixelTiles, num_threads: int, block: bool) -> np.ndarray:
    """Populated tiles in the order in which threads 0, 1, ... 0, 1, ... take them.

    Interleaved: neighbours in the image go to different threads. Block: each thread has one run of neighbouring tiles.
    """
    populated = populated_tiles(tiles)
    if not block:
        return populated
    blocks = np.array_split(populated, num_threads)  # the longer blocks come first
    rounds = [[part[k] for part in blocks if k < len(part)] for k in range(len(blocks[0]))]
    return np.array([tile for turn in rounds for tile in turn], dtype=np.int64)


def attributes(memory: IzbMemory, tiles: PixelTiles) -> np.ndarray:
    """float32 [tiles, 2, 4]: v[0] and v[1] of the kernel."""
    tile = np.arange(len(tiles.origins))
    first_pixel = tile * tiles.num_pairs * 2
    attribute = np.zeros((len(tile), 2, 4), np.float32)
    attribute[:, 0, 0] = -tiles.num_pairs
    attribute[:, 0, 1] = memory.first_node + memory.node_of_sample[first_pixel]
    attribute[:, 0, 2] = attribute[:, 0, 1] + 1
    attribute[:, 0, 3] = memory.first_pair + memory.place_of_pixel[first_pixel] // 2
    attribute[:, 1, :2] = tiles.origins
    return attribute


def constants(memory: IzbMemory, grid: Grid, tiles: PixelTiles, transform: LightTransform) -> np.ndarray:
    """float32 [256, 4]: c[] of the kernel."""
    constant = np.zeros((256, 4), np.float32)
    area, tiles_wide = grid.tile_area, grid.tiles_wide
    constant[0, 0] = 1
    constant[1] = transform.step_x
    constant[2] = transform.step_y
    constant[3] = transform.depth
    constant[4, 0] = grid.logical_width
    constant[5] = (1 / grid.physical_width, 1 / grid.physical_height) * 2
    constant[6] = (grid.tile_width, grid.tile_height) * 2
    constant[7] = (grid.tiles_wide, grid.tiles_high) * 2
    constant[8] = (area - grid.tile_width, tiles_wide * area - area) * 2
    constant[9] = (grid.tile_width, area) * 2
    constant[10] = (0, 4, 2, 3)
    constant[LAST_STEP - tiles.num_pairs : LAST_STEP] = _steps(memory, tiles)
    constant[LAST_CONSTANT - tiles.num_pairs : LAST_CONSTANT] = transform.pair
    return constant


def _steps(memory: IzbMemory, tiles: PixelTiles) -> np.ndarray:
    """float32 [num_pairs, 4] what is added to v[0] behind each pair of a tile; they are the same for all tiles."""
    pixels = np.diff(memory.place_of_pixel[: tiles.num_pairs * 2 : 2])
    steps = np.ones((tiles.num_pairs, 4), np.float32)
    steps[:-1, 1:3] = 2 * memory.storage.pool_threads or pixels[:, None]
    steps[:-1, 3] = pixels // 2
    return steps
