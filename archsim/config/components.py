"""The components of a machine, one section a kind, each with the checks that need no other component."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from archsim.config.dram import DramConfig, IdealDramConfig
from archsim.config.section import Count, Finding, Section, Size, Small, is_power_of_two, key_of, report
from archsim.config.stages import DelayStreamConfig, PoolConfig, StageConfig
from archsim.units import Cycles

ACCESS_BYTES = 16  # of one load or store ([Johnson04] sec. 6: 128 bits)
INTERLEAVED = "interleaved"  # as `tasks` of a core


class CoreConfig(Section):
    """`count` equal multithreaded processors: one instruction a cycle, round robin, free thread switches."""

    kind: Literal["core"]
    count: Small  # equal cores of this name
    threads: Small  # of each processor
    clock: str  # its clock, by name
    memory: str  # the cache that loads and stores go to
    locks: str | None  # the table that LOCK and UNLOCK go to; null: none
    tasks: str  # INTERLEAVED, or the fifo that hands tasks to the first free thread


class CacheConfig(Section):
    """A write-back, write-allocate cache with LRU replacement."""

    kind: Literal["cache"]
    private: bool = False  # one for each core of the groups that name it as their memory
    size: Size  # of all lines together: sets x ways x line
    ways: Count  # lines of a set
    line: Size  # a power of two
    hit_cycles: Annotated[Cycles, Field(ge=1, le=1_000_000)]  # from lookup to answer
    mshrs: Count  # lines that can be on their way
    targets: Count  # requests that can wait for one line
    ports: Small  # lookups a cycle
    next: str  # the cache or DRAM that misses go to
    clock: str  # its clock, by name: that of the cores above it

    @property
    def num_sets(self) -> int:
        return self.size // (self.ways * self.line)

    @model_validator(mode="after")
    def _check(self) -> CacheConfig:
        report(_check_cache(self))
        return self


class UnitConfig(Section):
    """A fixed-function stage that makes the cores one task every `interval_cycles`; 0: a task is always there."""

    kind: Literal["unit"]
    interval_cycles: Annotated[Cycles, Field(ge=0, le=1_000_000)]  # between two tasks; 0: one is always there
    output: str  # the fifo


class FifoConfig(Section):
    """A queue of at most `entries` tasks."""

    kind: Literal["fifo"]
    entries: Count  # tasks that it holds at most


class LocksConfig(Section):
    """A table of `count` on-chip locks."""

    kind: Literal["locks"]
    count: Count  # locks, numbered from 0
    ideal: bool = False  # every LOCK is granted at once, whoever else has it


_KINDS = {
    "core": "<CoreConfig>",
    "cache": "<CacheConfig>",
    "unit": "<UnitConfig>",
    "fifo": "<FifoConfig>",
    "locks": "<LocksConfig>",
    "delay_stream": "<DelayStreamConfig>",
    "pool": "<PoolConfig>",
    "dram": "<DramConfig>",
    "ideal_dram": "<IdealDramConfig>",
}


def _kind_tag(component: Any) -> str | None:
    kind = key_of(component, "kind") or ""
    if kind == "unit" and key_of(component, "output") is None:
        return "<StageConfig>"
    return _KINDS.get(kind)


ComponentConfig = Annotated[
    Annotated[CoreConfig, Tag("<CoreConfig>")]
    | Annotated[CacheConfig, Tag("<CacheConfig>")]
    | Annotated[UnitConfig, Tag("<UnitConfig>")]
    | Annotated[StageConfig, Tag("<StageConfig>")]
    | Annotated[FifoConfig, Tag("<FifoConfig>")]
    | Annotated[LocksConfig, Tag("<LocksConfig>")]
    | Annotated[DelayStreamConfig, Tag("<DelayStreamConfig>")]
    | Annotated[PoolConfig, Tag("<PoolConfig>")]
    | Annotated[DramConfig, Tag("<DramConfig>")]
    | Annotated[IdealDramConfig, Tag("<IdealDramConfig>")],
    Discriminator(_kind_tag),
]


def _check_cache(cache: CacheConfig) -> list[Finding]:
    found = []
    if cache.line < ACCESS_BYTES or not is_power_of_two(cache.line):
        what = f"must be a power of two of at least {ACCESS_BYTES} B (one access), not {cache.line} B"
        found.append(Finding(("line",), what))

    set_bytes = cache.ways * cache.line
    if cache.size % set_bytes or not is_power_of_two(cache.size // set_bytes):
        sets = f"{cache.size} B is {cache.size / set_bytes:g} times {cache.ways} ways of {cache.line} B"
        found.append(Finding(("size",), f"must be sets x ways x line with a power of two of sets: {sets}"))
    return found
