"""Which way of a set gives up its line, compiled: one branch for each policy, on one age of each way.

No policy costs anything at a hit but that age: the bits of a pseudo-LRU tree follow from it. A node points away
from its half that was used last, so to the half whose last use is longer ago.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import inlined
from archsim.lanes import LANES, least_lane, padded
from archsim.model.cache.spec import Replacement
from archsim.model.compiled import record

NO_WAY = -1
INVALID = -(1 << 62)  # tag of a way without a line
_WORD = 0xFFFFFFFF
# The oldest way of a set is that of the least age, so that finding it needs no branches: an age has, from its lowest
# bit on, the way's number, a request's, COMING. A set has at most 2**22 ways, a cache is asked at most 2**40 times.
_WAY_BITS = 22
COMING = 1 << 62  # in the age of a way of which a sector is on its way
_NO_AGE = (1 << 63) - 1  # of the ways that a set lacks to a multiple of LANES
UNUSED = (1 << _WAY_BITS) - 1  # ages up to this are of ways without a line

WAY = record(
    indices=(  # a bit for each sector
        "present",  # that is here
        "coming",  # that is on its way
        "dirty",  # that differs from the next level
    ),
)


def new_ages(num_ways: np.ndarray) -> np.ndarray:
    """[R, A] the ages of ways without a line, A a multiple of LANES. `num_ways`: [R] of each set."""
    ways = np.arange(padded(int(num_ways.max(initial=0))))
    return np.where(ways < num_ways[:, None], ways, _NO_AGE)


@inlined
def age(count, way):
    """The age of the way whose line request number `count` uses; 0: it has no line."""
    return count << _WAY_BITS | np.int64(way)


@inlined
def use(spec, ages, place, count):
    """Request number `count`, from 1 up, uses the line in this way, which has been here before."""
    if spec["replacement"] != Replacement.FIFO:
        ages[place] = ages[place] & COMING | age(count, place[1])


@inlined
def victim(spec, tags, ages, row, count):
    """The way of set `row` for the line of request number `count`, NO_WAY if all are on their way.

    `spec` has replacement, num_ways and seed; tags and ages are [R, A]. A way's age is that of the request that used
    its line last (FIFO: that brought it), with the bit COMING.
    """
    if spec["replacement"] == Replacement.LRU or spec["replacement"] == Replacement.FIFO:
        return _oldest(spec, ages, row)
    for way in range(spec["num_ways"]):
        if tags[row, way] == INVALID:
            return way
    if spec["replacement"] == Replacement.TREE_PLRU:
        wanted = _longest_unused_by_halves(ages, row, spec["num_ways"])
    else:
        wanted = random_way(spec["seed"], count, spec["num_ways"])
    return _first_free(spec, ages, row, wanted)


@inlined
def _oldest(spec, ages, row):
    """The first invalid way, else that of the line longest unused, or longest here."""
    oldest = _NO_AGE
    for first in range(0, spec["num_ways"], LANES):
        oldest = min(oldest, least_lane(ages, row, first, LANES))
    return oldest & UNUSED if oldest < COMING else NO_WAY


@inlined
def _longest_unused_by_halves(ages, row, num_ways):
    """Of the halves of the set the one whose last use is longer ago, of its halves again, down to one way."""
    low, high = 0, num_ways
    while high - low > 1:
        middle = (low + high) >> 1
        lower, upper = 0, 0
        for way in range(low, middle):
            lower = max(lower, ages[row, way] & ~COMING)
        for way in range(middle, high):
            upper = max(upper, ages[row, way] & ~COMING)
        if lower <= upper:
            high = middle
        else:
            low = middle
    return low


@inlined
def _first_free(spec, ages, row, wanted):
    """The first way at or after `wanted`, going round, that is not on its way."""
    for step in range(spec["num_ways"]):
        way = (wanted + step) % spec["num_ways"]
        if ages[row, way] < COMING:
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
