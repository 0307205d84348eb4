"""The compiled pipeline's spec and state, as its loop wants them.

They have the fields of the machine of cores that `machine/memory.py` uses: to the memory an access under way is what a
thread is, something that waits and is woken with the level that supplied the line. So `core` has a core for each
requester, units first, then delay streams, and a thread for each of its accesses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.machine.waits import WaitsState
from archsim.model.cache.compiled_state import CacheState
from archsim.model.compiled import QueueState, record
from archsim.model.core.compiled import CoreState
from archsim.model.core.spec import CoreSpec
from archsim.model.delay_stream.compiled import StreamsState
from archsim.model.dram.compiled import DramState
from archsim.model.dram.spec import DramSpec
from archsim.model.fifo.compiled import PipesState
from archsim.model.pool.compiled import PoolsState
from archsim.model.unit.compiled import StagesState


class Machine(NamedTuple):
    """PipelineSpec in plain integers and arrays of one type, so that one compilation serves all."""

    core: CoreSpec
    caches: np.ndarray  # CACHE_SPEC [K]
    dram: DramSpec
    burst_shift: int  # log2 of the bytes of a burst
    spare_slots: int  # free slots that a queue needs at the beginning of a cycle
    answer_clocks: int  # memory clocks from anything that the DRAM does to what it answers to that, at least
    producers: np.ndarray  # [C] unit that emits into the channel
    consumers: np.ndarray  # [C] unit that takes from it


WORK = record(
    "is_over",  # whether no chunk is to come
    "unit",  # that must have its next task before the run goes on
)


class State(NamedTuple):
    """Everything that changes during a run."""

    stages: StagesState
    pipes: PipesState
    streams: StreamsState
    stream_roused: (
        np.ndarray
    )  # [D] last cycle in which something that the delay stream waits for may have happened
    pools: PoolsState
    records: np.ndarray  # RECORD [n] loaded ones, unit by unit
    work: np.ndarray  # WORK [1]
    core: CoreState
    cache: CacheState
    dram: DramState
    answers: QueueState  # ANSWER [2] fetches answered by a cache, by the DRAM; the rank is its level
    filling: np.ndarray  # [fetches] those being filled in this cycle
    sources: np.ndarray  # [fetches] MSHR of the level above that it waited for, or LOOKUP_HIT
    waits: WaitsState
    run: np.ndarray  # RUN [1]
