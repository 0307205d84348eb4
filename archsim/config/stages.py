"""The components of a pipeline of fixed-function stages, one section a kind, with the checks that need no other."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from archsim.config.section import Count, Finding, Section, Size, Small, is_power_of_two, report
from archsim.units import Bytes, Cycles, format_bytes

MAX_RING_BYTES = 2**26
MAX_ITEM_BYTES = 2**15 - 1

StageCycles = Annotated[Cycles, Field(ge=1, le=1_000_000)]
Names = Annotated[tuple[str, ...], Field(strict=False, max_length=64)]


class StageConfig(Section):
    """A fixed-function unit of a pipeline: takes items from its inputs and emits items to its outputs, in order."""

    kind: Literal["unit"]
    clock: str  # its clock, by name: that of all units and of the caches below them
    interval_cycles: StageCycles  # from the beginning of a task to that of the next, at least
    latency_cycles: StageCycles  # from passing its front to leaving its back
    lanes: Small = 1  # steps of computation a cycle
    inputs: Names = ()  # fifos and delay streams that it takes items from; none: a source
    outputs: Names  # fifos and delay streams that it emits items to
    pools: Names = ()  # whose tokens it acquires or releases
    memory: str | None = None  # the cache or DRAM that loads and stores go to; null: it has none
    line: Size | None = None  # longest request to the DRAM; given if and only if that is its memory
    outstanding: Small = 1  # accesses under way
    in_flight: Small  # operations between its front and its back
    parts: Names = ()  # evaluators and tile caches that it is made with; it is no faster than its evaluators

    @model_validator(mode="after")
    def _check(self) -> StageConfig:
        report(_line_findings(self.line))
        return self


class DelayStreamConfig(Section):
    """A ring buffer in memory that holds items back until a marker, which bypasses it, releases them."""

    kind: Literal["delay_stream"]
    memory: str  # the DRAM
    size: Annotated[Bytes, Field(ge=1, le=MAX_RING_BYTES)]  # of the ring, a multiple of the line
    address: Annotated[Bytes, Field(ge=0, le=2**40)]  # of the ring, a multiple of the line; within the DRAM
    line: Size  # longest request to the DRAM
    outstanding: Small  # writes under way, and reads under way
    prefetch: Size  # no more is read ahead of the consumer; at least the largest item
    overflow: Literal["stall", "release"]  # what happens when items that wait for their marker fill the ring

    @model_validator(mode="after")
    def _check(self) -> DelayStreamConfig:
        found = _line_findings(self.line)
        for key, size in (("size", self.size), ("address", self.address)):
            if size % self.line:
                found.append(Finding((key,), f"must be a multiple of the line, {format_bytes(self.line)}"))
        report(found)
        return self


class PoolConfig(Section):
    """A pool of `count` tokens: acquire one or wait."""

    kind: Literal["pool"]
    count: Count  # tokens


def _line_findings(line: int | None) -> list[Finding]:
    if line is None or is_power_of_two(line):
        return []
    return [Finding(("line",), f"must be a power of two, not {line} B")]
