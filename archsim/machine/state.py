"""The compiled machine's spec and state, as its loop wants them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.machine.loading import Loaded
from archsim.machine.waits import WaitsState
from archsim.model.cache.compiled_state import CacheState
from archsim.model.compiled import QueueState, record
from archsim.model.core.compiled import CoreState
from archsim.model.core.spec import CoreSpec
from archsim.model.dram.compiled import DramState
from archsim.model.dram.spec import DramSpec
from archsim.model.fifo.compiled import FifoState
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks.compiled import LocksState
from archsim.model.unit.compiled import SourceState
from archsim.model.unit.spec import UnitSpec


class Machine(NamedTuple):
    """MachineSpec in plain integers and arrays of one type, so that one compilation serves all."""

    core: CoreSpec
    source: UnitSpec
    fifo: FifoSpec
    caches: np.ndarray  # CACHE_SPEC [K]
    dram: DramSpec
    core_cache: np.ndarray  # [C] cache of the core
    is_private: np.ndarray  # [K] whether one core and nobody else talks to the cache
    spare_slots: int  # free slots that a queue needs at the beginning of a cycle
    answer_clocks: int  # memory clocks from anything that the DRAM does to what it answers to that, at least


_RUN_FIELDS = (  # times in core cycles
    "cycle",  # being played; the last one when the run is over
    "horizon",  # until the end of this cycle only the DRAM can act besides issues and hits of private caches
    "next_answer",  # when the first answer on its way arrives
    "next_lookup",  # when the first cache has a request to look up
    "finished",  # tasks
    "last_finish",  # when the last of them was finished
    "last_clock",  # last memory clock at which a channel was woken
    "pause",  # cycle before which the caller is told the counts; NEVER: it does not want to be
    "needs_room",  # whether a queue may overflow in the next cycle
    "culprit",  # thread that unlocked what it did not hold
)
RUN = record(
    *_RUN_FIELDS, indices=("next_unit",)
)  # of a pipeline: first that has not been looked at in `cycle`
ANSWER = record("arrival", "rank", "requester")


class State(NamedTuple):
    """Everything that changes during a run."""

    core: CoreState
    locks: LocksState
    source: SourceState
    fifo: FifoState
    cache: CacheState
    dram: DramState
    answers: QueueState  # ANSWER [2] fetches answered by a cache, by the DRAM; the rank is its level
    filling: np.ndarray  # [fetches] those being filled in this cycle
    sources: np.ndarray  # [fetches] MSHR of the level above that it waited for, or LOOKUP_HIT
    waits: WaitsState
    tasks: Loaded
    run: np.ndarray  # RUN [1]
