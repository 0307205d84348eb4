"""The machine that plays one phase of work: the specs of its components, in plain integers."""

from __future__ import annotations

from typing import NamedTuple

from archsim.model.cache.spec import CacheSpec
from archsim.model.core.spec import CoreSpec
from archsim.model.dram.spec import DramSpec
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks.spec import LocksSpec
from archsim.model.unit.spec import UnitSpec


class MachineSpec(NamedTuple):
    """One group of cores over a tree of caches over a DRAM.

    Caches are numbered so that a child's index is smaller than its parent's. All caches run on the cores' clock.
    """

    core: CoreSpec
    core_cache: tuple[int, ...]  # [num_cores] index of the cache each core talks to
    locks: LocksSpec
    source: UnitSpec  # what makes the tasks, for TaskOrder.FIRST_FREE
    fifo: FifoSpec  # between the source and the cores
    caches: tuple[CacheSpec, ...]
    dram: DramSpec
