"""The components of a machine, one section a kind, each with the checks that need no other component."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from archsim.config.section import Count, Finding, Section, is_power_of_two, key_of, report
from archsim.units import Bytes, Cycles, format_bytes

ACCESS_BYTES = 16  # of one load or store ([Johnson04] sec. 6: 128 bits)
MAX_DRAM_BYTES = 2**40
ADDRESS_FIELDS = ("row", "bank", "line", "channel", "offset")
INTERLEAVED = "interleaved"  # as `tasks` of a core

Size = Annotated[Bytes, Field(ge=1, le=2**40)]
Small = Annotated[int, Field(ge=1, le=4096)]
Clocks = Annotated[int, Field(ge=1, le=1_000_000, json_schema_extra={"unit": "memory clocks"})]


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
    """A fixed-function stage that makes one task every `interval_cycles`; 0: a task is always there."""

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


class TimingConfig(Section):
    """Constraints of the DRAM's data sheet in memory clocks."""

    n_cl: Clocks  # read command to first data
    n_wl: Clocks  # write command to first data
    n_rcd_read: Clocks  # activate to read
    n_rcd_write: Clocks  # activate to write
    n_rp: Clocks  # precharge to activate
    n_ras: Clocks  # activate to precharge
    n_rc: Clocks  # activate to activate, same bank
    n_rrd: Clocks  # activate to activate, other bank
    n_ccd: Clocks  # column command to column command
    n_rtp: Clocks  # read to precharge
    n_wr: Clocks  # last data written to precharge
    n_wtr: Clocks  # last data written to read
    n_rtw: Clocks  # read to write
    n_rfc: Clocks  # refresh to activate
    n_refi: Annotated[int, Field(ge=0, le=1_000_000_000)]  # between refreshes; 0: never

    @model_validator(mode="after")
    def _check(self) -> TimingConfig:
        report(_check_timing(self))
        return self


class DramConfig(Section):
    """Independent DRAM channels, each with its own commands, data and banks."""

    kind: Literal["dram"]
    clock: str  # its clock, by name
    channels: Small  # independent channels
    banks: Small  # of a channel
    rows: Count  # of a bank
    row_bytes: Size  # of one bank
    channel_width: Size  # bytes of one beat
    burst_beats: Annotated[int, Field(ge=2, le=256)]  # beats of one column command
    data_rate: Literal[2]  # beats a clock
    address_map: str  # ADDRESS_FIELDS from the most to the least significant bits
    queue_entries: Count  # oldest requests of a channel that the scheduler sees
    scheduler: Literal["fcfs", "fr_fcfs"]  # fcfs: the oldest request; fr_fcfs: row hits first
    max_wait_clocks: Annotated[int, Field(ge=0, le=1_000_000_000)]  # fr_fcfs: a longer wait is served first
    timing: TimingConfig  # constraints of the data sheet

    def address_fields(self, line_bytes: int) -> dict[str, tuple[int, int]]:
        """(shift, bits) of every field of the byte address, for the last cache's line size."""
        sizes = {
            "offset": line_bytes,
            "channel": self.channels,
            "line": self.row_bytes // line_bytes,
            "bank": self.banks,
            "row": self.rows,
        }
        fields, shift = {}, 0
        for name in reversed(self.address_map.split(":")):
            bits = sizes[name].bit_length() - 1
            fields[name] = (shift, bits)
            shift += bits
        return fields

    @model_validator(mode="after")
    def _check(self) -> DramConfig:
        report(_check_dram(self))
        return self


_KINDS = {
    "core": "<CoreConfig>",
    "cache": "<CacheConfig>",
    "unit": "<UnitConfig>",
    "fifo": "<FifoConfig>",
    "locks": "<LocksConfig>",
    "dram": "<DramConfig>",
}


def _kind_tag(component: Any) -> str | None:
    return _KINDS.get(key_of(component, "kind") or "")


ComponentConfig = Annotated[
    Annotated[CoreConfig, Tag("<CoreConfig>")]
    | Annotated[CacheConfig, Tag("<CacheConfig>")]
    | Annotated[UnitConfig, Tag("<UnitConfig>")]
    | Annotated[FifoConfig, Tag("<FifoConfig>")]
    | Annotated[LocksConfig, Tag("<LocksConfig>")]
    | Annotated[DramConfig, Tag("<DramConfig>")],
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


def _check_timing(timing: TimingConfig) -> list[Finding]:
    found = []
    if timing.n_ras < timing.n_rcd_read:
        found.append(Finding(("n_ras",), f"must be at least n_rcd_read, {timing.n_rcd_read}"))
    if timing.n_rc < timing.n_ras + timing.n_rp:
        found.append(Finding(("n_rc",), f"must be at least n_ras + n_rp, {timing.n_ras + timing.n_rp}"))
    least = 4 * (timing.n_rfc + timing.n_rc)  # or refresh would leave no time to serve a request
    if 0 < timing.n_refi < least:
        found.append(Finding(("n_refi",), f"must be at least 4 (n_rfc + n_rc), {least}, or 0 for no refresh"))
    return found


def _check_dram(dram: DramConfig) -> list[Finding]:
    sizes = [("channels", dram.channels), ("banks", dram.banks), ("rows", dram.rows)]
    sizes += [("row_bytes", dram.row_bytes), ("channel_width", dram.channel_width)]
    sizes += [("burst_beats", dram.burst_beats)]
    found = [
        Finding((key,), f"must be a power of two, not {size}")
        for key, size in sizes
        if not is_power_of_two(size)
    ]

    if dram.channels * dram.banks * dram.rows * dram.row_bytes > MAX_DRAM_BYTES:
        found.append(
            Finding(("rows",), f"channels x banks x rows x row_bytes is above {format_bytes(MAX_DRAM_BYTES)}")
        )
    if dram.timing.n_ccd < dram.burst_beats // 2:
        what = f"must be at least the clocks of a burst's data, {dram.burst_beats // 2}"
        found.append(Finding(("timing", "n_ccd"), what))
    names = dram.address_map.split(":")
    if sorted(names) != sorted(ADDRESS_FIELDS):
        what = f"must hold {', '.join(ADDRESS_FIELDS)} once each, with ':' between, not '{dram.address_map}'"
        found.append(Finding(("address_map",), what))
    elif names[-1] != "offset":
        found.append(Finding(("address_map",), "must end with offset: a request stays in one row"))
    return found
