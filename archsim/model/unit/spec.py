"""In-order fixed-function stages: what they are."""

from enum import IntEnum
from typing import NamedTuple

NO_MEMORY = -2  # `memory` of a unit without accesses


class UnitSpec(NamedTuple):
    """A stage that hands out one item every `interval_cycles`; 0 means that an item is always there (ideal)."""

    interval_cycles: int


class StageSpec(NamedTuple):
    """A unit of a pipeline. Channels are numbered: the machine's fifos, then its delay streams."""

    interval_cycles: int  # from the beginning of a task to that of the next, at least
    latency_cycles: int  # of an operation through the unit, at least 1
    lanes: int  # compute steps a cycle
    inputs: tuple[int, ...]  # channels
    outputs: tuple[int, ...]  # channels
    pools: tuple[int, ...]
    memory: int  # index of a cache, DRAM_PARENT or NO_MEMORY
    line_bytes: int  # of one access
    outstanding: int  # accesses under way
    in_flight: int  # operations between front and back


class Slot(IntEnum):
    """What the front of a unit does in a cycle."""

    BUSY = 0  # computes, or is within the interval of its task
    NO_WORK = 1  # waits for an item, or has done all its tasks
    MEMORY = 2  # waits for a free access or a delay stream's transfer, or is held back by a LOAD or STORE
    OUTPUT = 3  # is held back by an EMIT to a full fifo
    DELAY_STREAM = 4  # is held back by an EMIT to a full delay stream
    LATENCY = 5  # is held back by an operation that is on its way through the unit
    POOL = 6  # waits for a token
