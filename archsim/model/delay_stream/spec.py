"""A ring buffer in memory that holds items back until a marker releases them: what it is."""

from enum import IntEnum
from typing import NamedTuple


class Overflow(IntEnum):
    """What happens when the items that wait for their marker fill the ring."""

    STALL = 0  # the producer waits
    RELEASE = 1  # the oldest are released early, as few as make room


class DelayStreamSpec(NamedTuple):
    """A ring of `ring_bytes` bytes in DRAM, at addresses from `base` on, written and read in lines."""

    ring_bytes: int  # a multiple of line_bytes
    base: int  # a multiple of line_bytes
    line_bytes: int  # of one request to the DRAM, at most
    outstanding: int  # writes under way, and reads under way
    prefetch_bytes: int  # nothing more is read while so much was asked for and not taken; no item is larger
    overflow: int  # Overflow
