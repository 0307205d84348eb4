"""Which way of a set gives up its line, compiled: one branch for each policy, on one time of each way.

No policy costs anything at a hit but that time: the bits of a pseudo-LRU tree follow from it. A node points away
from its half that was used last, so to the half whose last use is longer ago.
"""

from __future__ import annotations

from archsim.jit import inlined
from archsim.model.cache.spec import Replacement
from archsim.model.compiled import NEVER, record

NO_WAY = -1
INVALID = -(1 << 62)  # tag of a way without a line
_WORD = 0xFFFFFFFF

WAY = record(
    "used",  # the cache's request that used the line last (FIFO: that brought it), 0 for never
    indices=(  # a bit for each sector
        "present",  # that is here
        "coming",  # that is on its way
        "dirty",  # that differs from the next level
    ),
)


@inlined
def use(spec, way, count):
    """Request number `count` uses the line in this way, which has been here before."""
    if spec["replacement"] != Replacement.FIFO:
        way["used"] = count


@inlined
def victim(spec, tags, ways, row, count):
    """The way of set `row` for the line of request number `count`, NO_WAY if all are on their way.

    `spec` has replacement, num_ways and seed; tags and WAYs are [R, A].
    """
    if spec["replacement"] == Replacement.LRU or spec["replacement"] == Replacement.FIFO:
        return _oldest(spec, tags, ways, row)
    for way in range(spec["num_ways"]):
        if tags[row, way] == INVALID:
            return way
    if spec["replacement"] == Replacement.TREE_PLRU:
        wanted = _longest_unused_by_halves(ways, row, spec["num_ways"])
    else:
        wanted = random_way(spec["seed"], count, spec["num_ways"])
    return _first_free(spec, ways, row, wanted)


@inlined
def _oldest(spec, tags, ways, row):
    """The first invalid way, else that of the line longest unused, or longest here."""
    found, oldest = NO_WAY, NEVER
    for number in range(spec["num_ways"]):
        time = -1 if tags[row, number] == INVALID else ways[row, number]["used"]
        is_older = (time < oldest) & (ways[row, number]["coming"] == 0)
        found = number if is_older else found
        oldest = time if is_older else oldest
    return found


@inlined
def _longest_unused_by_halves(ways, row, num_ways):
    """Of the halves of the set the one whose last use is longer ago, of its halves again, down to one way."""
    low, high = 0, num_ways
    while high - low > 1:
        middle = (low + high) >> 1
        lower, upper = 0, 0
        for way in range(low, middle):
            lower = max(lower, ways[row, way]["used"])
        for way in range(middle, high):
            upper = max(upper, ways[row, way]["used"])
        if lower <= upper:
            high = middle
        else:
            low = middle
    return low


@inlined
def _first_free(spec, ways, row, wanted):
    """The first way at or after `wanted`, going round, that is not on its way."""
    for step in range(spec["num_ways"]):
        way = (wanted + step) % spec["num_ways"]
        if ways[row, way]["coming"] == 0:
            return way
    return NO_WAY


@inlined
def random_way(seed, count, num_ways):
    """A way drawn for the cache's request number `count`, the same in every run with this seed."""
    return hashed(hashed(seed & _WORD) ^ (count & _WORD)) * num_ways >> 32


@inlined
def hashed(number):
    """32 bits in which every one of the number's 32 bits counts; no product leaves 63 bits."""
    number = ((number ^ (number >> 16)) * 0x21F0AAAD) & _WORD
    number = ((number ^ (number >> 15)) * 0x735A2D97) & _WORD
    return number ^ (number >> 15)
