"""The machine, compiled: plays work on a spec and returns exactly the counters of reference.py, much faster.

Time is counted in core cycles; the loop visits only those in which something can happen. The order of what meets in
one cycle is that of README.md: fills, source, issue, lookups; then the DRAM plays the memory clocks that lie before
the next cycle visited.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from archsim.errors import ArchsimError, DeadlockError, Problem, fail
from archsim.jit import njit
from archsim.machine.counters import STALL_LOCK, STALL_NO_WORK, STALL_SUPPLIER, Counters
from archsim.machine.loading import Loaded, load_next, nothing_loaded
from archsim.machine.spec import MachineSpec
from archsim.model.cache import compiled as cache_model
from archsim.model.cache.compiled import READ, WRITE, WRITEBACK, CacheState, CacheTable, Request
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.core import compiled as core_model
from archsim.model.core.compiled import NO_TASK, NO_THREAD, CoreState
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.dram import compiled as dram_model
from archsim.model.dram.compiled import DramState
from archsim.model.dram.spec import DramSpec
from archsim.model.fifo import compiled as fifo_model
from archsim.model.fifo.compiled import NEVER, FifoState, QueueState
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks import compiled as locks_model
from archsim.model.locks.compiled import LocksState
from archsim.model.unit import compiled as unit_model
from archsim.model.unit.compiled import SourceState
from archsim.model.unit.spec import UnitSpec
from archsim.trace.records import Op
from archsim.trace.stream import Work

Progress = Callable[[int, int], Any]  # called with tasks finished, tasks in all

RUNNING, OVER, NEEDS_TASKS, NEEDS_ROOM, BAD_UNLOCK = range(5)  # why `play` returned

ANSWER = np.dtype([(name, np.int64) for name in ("arrival", "rank", "requester")])
