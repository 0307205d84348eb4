"""A set-associative cache: what it is."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

DRAM_PARENT = -1  # `parent` of a cache whose next level is the DRAM
MAX_SECTORS = 32  # of a line


class Replacement(IntEnum):
    """Which line leaves a full set; invalid ways are taken first, lines on their way are never taken."""

    LRU = 0  # the least recently used
    FIFO = 1  # the one that has been there longest
    TREE_PLRU = 2  # where a binary tree of bits points that every use turns away from itself
    RANDOM = 3  # drawn by a hash of the cache's seed and its count of accepted requests


class WritePolicy(IntEnum):
    """When a write to a line that is here reaches the next level."""

    WRITE_BACK = 0  # when the line leaves
    WRITE_THROUGH = 1  # at once


class VictimOrder(IntEnum):
    """What a miss sends first, and so what the next level looks up first."""

    FETCH_FIRST = 0  # the fetch, then the victim's write-back: as Dinero IV does it
    WRITE_BACK_FIRST = 1


class Arbiter(IntEnum):
    """Which of the arrived requests is looked up next; one sender's requests stay in order."""

    ARRIVAL = 0  # the one that arrived first; of one tick, that of the sender with the lowest number
    FIXED_PRIORITY = 1  # that of the sender with the lowest number
    ROUND_ROBIN = 2  # that of the next sender after the one that was served last


class ClearSpec(NamedTuple):
    """A bit for each block of some memory that tells whether the block is known to be cleared in the next level."""

    block_bytes: int  # a power of two; 0: no bits
    first_address: int  # a multiple of block_bytes
    num_blocks: int
    is_clear_at_first: int


NO_CLEAR_BITS = ClearSpec(0, 0, 0, 0)


class CacheSpec(NamedTuple):
    """One cache. A line is allocated when the miss is found."""

    num_sets: int  # a power of two
    num_ways: int
    line_bytes: int  # a power of two
    hit_cycles: int  # request to answer on a hit, and request to next level on a miss
    num_mshrs: int  # fetches that can be on their way
    num_targets: int  # requests that can wait for one fetch, the first one included
    num_ports: int  # lookups a cycle
    parent: int  # index of the next level's cache, or DRAM_PARENT
    num_sectors: int = 1  # parts of a line that are fetched, present and dirty by themselves; a power of two
    replacement: int = Replacement.LRU
    seed: int = 0  # of RANDOM
    write_policy: int = WritePolicy.WRITE_BACK
    allocates_writes: int = 1  # 0: a write that finds no line goes to the next level as it is
    victim_order: int = VictimOrder.FETCH_FIRST
    num_write_entries: int = (
        0  # writes sent and not yet accepted by the next level that hold up the next one; 0: none do
    )
    arbiter: int = Arbiter.ARRIVAL
    clear: ClearSpec = NO_CLEAR_BITS

    @property
    def sector_bytes(self) -> int:
        return self.line_bytes // self.num_sectors
