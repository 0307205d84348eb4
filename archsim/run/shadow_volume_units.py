"""The fixed-function stages beside the kernels: the same volumes in the same batches, and how the results differ."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.execute.hsv_memory import classification, tile_states
from archsim.execute.hsv_stages import Drawn, Stages
from archsim.shadow_volumes.hierarchical import Memory, Resources, new_memory, settle_all, update
from archsim.shadow_volumes.psv_cache import ENTRY_BYTES, CacheShape
from archsim.shadow_volumes.seen import SeenVolumes, Space, new_space
from archsim.shadow_volumes.stage1 import classify

_NO_MATTER = CacheShape(ENTRY_BYTES, ENTRY_BYTES, 1)  # bytes moved are not looked at


class Units(NamedTuple):
    """Volumes on their way through both stages."""

    seen: SeenVolumes
    space: Space
    memory: Memory
    early: np.ndarray  # int64 [num_volumes] no triangle leaves before its volume is classified


class Differences(NamedTuple):
    """Between kernels and units; all 0 if they agree."""

    classified: int  # entries of PSV buffers, volume by volume
    drawn: int  # volumes of which other numbers of pixels or tiles of depth were drawn
    states: int  # tiles of the low-resolution stencil buffer, batch by batch


def new_units(seen: SeenVolumes, num_buffers: int) -> Units:
    """Before the first volume."""
    resources = Resources(num_buffers, _NO_MATTER, 0)
    early = np.zeros(len(seen.volumes.z_pass), np.int64)
    return Units(seen, new_space(seen.screen), new_memory(seen.screen, resources), early)


def differences_of_stage_1(units: Units, stages: Stages, batch: tuple[int, int]) -> Differences:
    """After Stage 1 of a batch: classify it by the unit, too."""
    psv, number = units.memory[0][0], 0
    for volume in range(*batch):
        classify(volume, _triangles(units, volume), units.seen, units.space, units.memory[0])
        buffer = volume % len(psv.boundary)
        boundary, stencil = classification(stages.memory, buffer, units.seen.screen)
        number += int((boundary != psv.boundary[buffer]).sum() + (stencil != psv.stencil[buffer]).sum())
    return Differences(number, 0, 0)


def differences_of_stage_2(
    units: Units, stages: Stages, batch: tuple[int, int], drawn: list[Drawn]
) -> Differences:
    """After Stage 2 of a batch, which drew so much of each volume: update by the unit, too."""
    number = 0
    for volume in range(*batch):
        span = _triangles(units, volume)
        counts = update(volume, span, units.early, units.seen, units.space, units.memory)
        number += (drawn[volume].pixels, drawn[volume].depth_tiles) != tuple(counts)
    settle_all(units.seen.screen, *units.memory[1])
    states = tile_states(stages.memory, units.seen.screen) != units.memory[1][1].state
    return Differences(0, number, int(states.sum()))


def together(a: Differences, b: Differences) -> Differences:
    """The sum."""
    return Differences(*(x + y for x, y in zip(a, b, strict=True)))


def _triangles(units: Units, volume: int) -> tuple[int, int]:
    starts = units.seen.volumes.starts
    return int(starts[volume]), int(starts[volume + 1])
