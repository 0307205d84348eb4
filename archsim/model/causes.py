"""What a request waits for, level by level: the causes of a stalled cycle, in numbers.

machine/README.md, *Where time goes*, says when which of them holds.
"""

from __future__ import annotations

from enum import IntEnum


class AtCache(IntEnum):
    """What a request waits for at a cache."""

    LOOKUP = 0  # its lookup, until it hits or reaches the next level
    PORT = 1  # its turn: other requests are looked up first
    TARGET = 2  # a free target, or the end of one of several fetches that bring its bytes
    WAY = 3  # a way whose line is not on its way
    MSHR = 4  # a free MSHR
    WRITE_QUEUE = 5  # room for a write to the next level


class AtDram(IntEnum):
    """What a request waits for at the DRAM."""

    QUEUE = 0  # other requests
    REFRESH = 1
    ACTIVATION = 2  # its row, closed or another one before
    TURNAROUND = 3  # the bus, that carried data the other way
    BUS = 4  # its data, from the column command on


AT_CACHE = len(AtCache)


def first_cause(level: int) -> int:
    """Number of the first cause at a level: a cache by its index, or the DRAM by the number of caches."""
    return AT_CACHE * level


def num_causes(num_caches: int) -> int:
    """Causes at all levels of a hierarchy."""
    return first_cause(num_caches) + len(AtDram)


def level_of(cause: int, num_caches: int) -> int:
    """The level of a cause."""
    return min(cause // AT_CACHE, num_caches)
