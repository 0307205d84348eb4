"""Both stages of hierarchical shadow volumes as programs: `kernels/hsv_stage1.s` and `hsv_stage2.s`.

Volumes are taken in batches of as many as there are PSV buffers: the buffers are cleared, Stage 1 classifies all
volumes of the batch, then Stage 2 takes their triangles once more. That is the two-pass implementation of [Aila04]
sec. 4.2; nothing has to be delayed, so nothing overflows.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from archsim.execute.hsv_memory import ENTRY_WORDS, MET, HsvMemory, lay_out, set_tile_states
from archsim.execute.interpreter import Executed, execute
from archsim.isa.assembler import load_kernel
from archsim.isa.program import NUM_LOCKS
from archsim.shadow_volumes.blocks import Blocks, blocks_of, count_blocks, draw_tiles, tiles_of
from archsim.shadow_volumes.hierarchical import LIT, MIXED, SHADOWED
from archsim.shadow_volumes.seen import SeenVolumes, Space, new_space
from archsim.shadow_volumes.stencil import Stencil, new_stencil, tile_ranges
from archsim.trace.records import Tasks
from archsim.trace.stream import Work, chunked

STAGE_1, STAGE_2 = "hsv_stage1", "hsv_stage2"
CLEARED = 64  # elements of 16 bytes that a task clears
CHUNK_TASKS = 1 << 14
_ELEMENT_WORDS = 4


class Drawn(NamedTuple):
    """What was drawn pixel by pixel for one volume."""

    pixels: int  # stencil operations
    depth_tiles: int
    tiles: np.ndarray  # int64 [n] their numbers, as Stage 2 handed them on


NOTHING = Drawn(0, 0, np.zeros(0, np.int64))


class Stages(NamedTuple):
    """Volumes on their way through both kernels."""

    seen: SeenVolumes
    space: Space
    counts: np.ndarray  # int64 [num_triangles] blocks that each meets
    memory: HsvMemory
    stencil: Stencil

    def batches(self) -> list[tuple[int, int]]:
        """Half-open ranges of volumes."""
        num_volumes, size = len(self.seen.volumes.z_pass), self.memory.num_buffers
        return [(first, min(first + size, num_volumes)) for first in range(0, num_volumes, size)]


def prepare_stages(seen: SeenVolumes, num_buffers: int) -> Stages:
    """Before the first volume: everything is clear and lit."""
    space = new_space(seen.screen)
    memory, stencil = lay_out(seen.screen, num_buffers), new_stencil(seen.screen)
    return Stages(seen, space, count_blocks(seen, space), memory, stencil)


def clear_work(stages: Stages) -> Work:
    """Clear all PSV buffers, by the kernel that clears the arrays of irregular z-buffers: one task for each KiB."""
    memory = stages.memory
    num_elements = -(-memory.num_buffers * memory.num_blocks * ENTRY_WORDS // _ELEMENT_WORDS)
    runs = [(-min(CLEARED, num_elements - k), k, 0, 0) for k in range(0, num_elements, CLEARED)]
    attributes, constants = np.array(runs, np.float32)[:, None], np.zeros((256, 4), np.float32)
    constants[0, :2] = 1

    def chunks() -> Iterator[Tasks]:
        yield execute(load_kernel("izb_clear"), attributes, constants, memory.windows, memory.words).tasks

    return chunked(len(runs), chunks())


def classify_work(stages: Stages, batch: tuple[int, int]) -> Work:
    """Stage 1 of a batch: one task for each triangle and block. The PSV buffers hold the result at its end."""

    def chunks() -> Iterator[Tasks]:
        for volume in range(*batch):
            for _, done in _executed(STAGE_1, volume, stages):
                yield done.tasks

    starts = stages.seen.volumes.starts
    return chunked(int(stages.counts[starts[batch[0]] : starts[batch[1]]].sum()), chunks())


def update_work(stages: Stages, batch: tuple[int, int], drawn: list[Drawn]) -> Work:
    """Stage 2 of a batch that is classified; what its tiles take to draw is put into `drawn`, [num_volumes]."""

    def chunks() -> Iterator[Tasks]:
        for volume in range(*batch):
            handed_on = []  # (triangles, tiles) of each chunk
            last = None  # whoever takes the last chunk of all does not ask for another
            for blocks, done in _executed(STAGE_2, volume, stages):
                if last is not None:
                    yield last
                per_task = np.diff(done.emitted_starts)
                handed_on.append(
                    (np.repeat(blocks.triangle, per_task).astype(np.int64), done.emitted_address)
                )
                last = done.tasks
            if last is not None:
                triangles, tiles = (np.concatenate(parts) for parts in zip(*handed_on, strict=True))
                drawn[volume] = _draw(stages, volume, triangles, tiles)
                yield last

    drawn_from, starts = stages.seen.volumes.drawn, stages.seen.volumes.starts
    parts = [stages.counts[drawn_from[volume] : starts[volume + 1]].sum() for volume in range(*batch)]
    return chunked(int(sum(parts)), chunks())


def _executed(kernel: str, volume: int, stages: Stages) -> Iterator[tuple[Blocks, Executed]]:
    """A kernel run on a volume, some triangles at a time."""
    program, memory = load_kernel(kernel), stages.memory
    firsts = stages.seen.volumes.starts if kernel == STAGE_1 else stages.seen.volumes.drawn
    for first, end, number in _spans(
        stages, int(firsts[volume]), int(stages.seen.volumes.starts[volume + 1])
    ):
        blocks = blocks_of(volume, (first, end), number, stages.seen, stages.space)
        given = attributes(blocks, volume, stages)
        yield blocks, execute(program, given, constants(), memory.windows, memory.words)


def _spans(stages: Stages, start: int, end: int) -> Iterator[tuple[int, int, int]]:
    """(first triangle, end, blocks) of the parts of triangles start ... end - 1, each of about CHUNK_TASKS blocks."""
    part = np.cumsum(stages.counts[start:end]) // CHUNK_TASKS
    cuts = [start, *(start + 1 + np.flatnonzero(np.diff(part))).tolist(), end]
    for first, last in pairwise(cuts):
        yield first, last, int(stages.counts[first:last].sum())


def attributes(blocks: Blocks, volume: int, stages: Stages) -> np.ndarray:
    """float32 [n, 3, 4]: v[0] ... v[2] of both kernels."""
    memory = stages.memory
    block = blocks.row.astype(np.int64) * memory.block_columns + blocks.column
    attribute = np.zeros((len(block), 3, 4), np.float32)
    attribute[:, 0, 0] = volume % memory.num_buffers * memory.num_blocks + block
    attribute[:, 0, 1] = 2 * block
    attribute[:, 0, 2] = block % NUM_LOCKS
    attribute[:, 0, 3] = blocks.operation
    attribute[:, 1] = blocks.relation
    attribute[:, 2] = tiles_of(blocks, stages.seen.screen.columns)
    return attribute


def constants() -> np.ndarray:
    """float32 [256, 4]: c[] of both kernels."""
    constant, bits = np.zeros((256, 4), np.float32), 2.0 ** np.arange(4)
    constant[0] = (0, 1, 0.5, 2)
    constant[1] = 1 / (2 * bits)
    constant[2] = bits
    constant[3] = 1 / (2 * MET * bits)
    constant[4] = MET * bits
    return constant


def _draw(stages: Stages, volume: int, triangles: np.ndarray, tiles: np.ndarray) -> Drawn:
    """Draw what Stage 2 handed on, and bring Smin and Smax of those tiles up to date."""
    seen, stencil = stages.seen, stages.stencil
    pixels, depth_tiles = draw_tiles(volume, triangles, tiles, seen, stages.space, stencil)

    changed = np.unique(tiles)
    low, high = tile_ranges(changed, seen.screen, stencil)
    states = np.where(low > 0, SHADOWED, np.where(high <= 0, LIT, MIXED))
    set_tile_states(stages.memory, changed, states, seen.screen)
    return Drawn(int(pixels), int(depth_tiles), tiles)
