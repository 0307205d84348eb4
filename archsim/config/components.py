"""The components of a machine, one section a kind, each with the checks that need no other component."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, RootModel, Tag, model_validator

from archsim.config.dram import DramConfig, IdealDramConfig
from archsim.config.section import Count, Finding, Section, Size, Small, is_power_of_two, key_of, report
from archsim.config.stages import DelayStreamConfig, PoolConfig, StageConfig
from archsim.config.tiles import EvaluatorConfig, TileCacheConfig
from archsim.units import Bytes, Cycles, format_bytes

ACCESS_BYTES = 16  # of one load or store ([Johnson04] sec. 6: 128 bits)
MAX_SECTORS = 32  # of a line
MAX_CLEAR_BITS = 2**24  # of a cache
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


class ClearBitsConfig(Section):
    """A bit for each block of some memory: whether it is known to be cleared, so that it need not be fetched."""

    block: Size  # bytes that one bit stands for; a power of two
    start: Annotated[Bytes, Field(ge=0, le=2**40)] = 0  # address of the first block
    size: Size  # of the memory that has bits
    at_start: Literal["clear", "unknown"] = "unknown"  # what the bits say before the first CLEAR

    @model_validator(mode="after")
    def _check(self) -> ClearBitsConfig:
        report(_check_clear_bits(self))
        return self


class CacheConfig(Section):
    """A cache: any size, ways and line; what it does with writes, victims and several requests at a time."""

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
    replacement: Literal["lru", "fifo", "tree_plru", "random"] = (
        "lru"  # who leaves a full set; random: by the run's seed
    )
    write_policy: Literal["write_back", "write_through"] = "write_back"  # when a write reaches the next level
    write_allocate: bool = True  # false: a write that finds no line goes to the next level and leaves no line
    sector: Size | None = (
        None  # part of a line that is fetched and written back by itself; null: the whole line
    )
    victim_order: Literal["fetch_first", "write_back_first"] = (
        "fetch_first"  # what a miss with a dirty victim sends first
    )
    write_queue: Annotated[int, Field(ge=0, le=1_000_000)] = (
        0  # writes that wait for the next level; 0: any number
    )
    arbiter: Literal["arrival", "fixed_priority", "round_robin"] = (
        "arrival"  # whose request is looked up next
    )
    clear_bits: ClearBitsConfig | None = (
        None  # memory that need not be fetched while it is known to be cleared
    )

    @property
    def num_sets(self) -> int:
        return self.size // (self.ways * self.line)

    @property
    def num_sectors(self) -> int:
        return self.line // self.sector if self.sector else 1

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
    "evaluator": "<EvaluatorConfig>",
    "tile_cache": "<TileCacheConfig>",
    "dram": "<DramConfig>",
    "ideal_dram": "<IdealDramConfig>",
}


def is_component(kind: object) -> bool:
    """Whether there are components of this kind."""
    return kind in _KINDS


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
    | Annotated[EvaluatorConfig, Tag("<EvaluatorConfig>")]
    | Annotated[TileCacheConfig, Tag("<TileCacheConfig>")]
    | Annotated[DramConfig, Tag("<DramConfig>")]
    | Annotated[IdealDramConfig, Tag("<IdealDramConfig>")],
    Discriminator(_kind_tag),
]


class ComponentFile(RootModel[ComponentConfig]):
    """A component by itself, of any kind."""


def _check_cache(cache: CacheConfig) -> list[Finding]:
    found = []
    if cache.line < ACCESS_BYTES or not is_power_of_two(cache.line):
        what = f"must be a power of two of at least {ACCESS_BYTES} B (one access), not {cache.line} B"
        found.append(Finding(("line",), what))

    set_bytes = cache.ways * cache.line
    if cache.size % set_bytes or not is_power_of_two(cache.size // set_bytes):
        sets = f"{cache.size} B is {cache.size / set_bytes:g} times {cache.ways} ways of {cache.line} B"
        found.append(Finding(("size",), f"must be sets x ways x line with a power of two of sets: {sets}"))
    if cache.sector is not None and not (
        is_power_of_two(cache.sector) and 1 <= cache.line // cache.sector <= MAX_SECTORS
    ):
        what = f"must be a power of two and a line hold 1 to {MAX_SECTORS} of them, not {format_bytes(cache.sector)}"
        found.append(Finding(("sector",), what))
    return found


def _check_clear_bits(bits: ClearBitsConfig) -> list[Finding]:
    if not is_power_of_two(bits.block):
        return [Finding(("block",), f"must be a power of two, not {bits.block} B")]
    if bits.size // bits.block > MAX_CLEAR_BITS:
        return [Finding(("size",), f"holds more than {MAX_CLEAR_BITS} blocks of {format_bytes(bits.block)}")]
    sizes = (("start", bits.start), ("size", bits.size))
    return [
        Finding((key,), f"must be a whole number of blocks of {format_bytes(bits.block)}")
        for key, size in sizes
        if size % bits.block
    ]
