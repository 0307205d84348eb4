"""A set-associative cache: what it is."""

from typing import NamedTuple

DRAM_PARENT = -1  # `parent` of a cache whose next level is the DRAM


class CacheSpec(NamedTuple):
    """One cache. Write-back, write-allocate, LRU, a line is allocated when the miss is found."""

    num_sets: int  # a power of two
    num_ways: int
    line_bytes: int  # a power of two
    hit_cycles: int  # request to answer on a hit, and request to next level on a miss
    num_mshrs: int  # lines that can be on their way
    num_targets: int  # requests that can wait for one line, the first one included
    num_ports: int  # lookups a cycle
    parent: int  # index of the next level's cache, or DRAM_PARENT
