"""Caches without time: one requester, a chain of caches, every request finished before the next one is made.

It counts what Dinero IV counts (Edler and Hill 1998), for the policies that both have: requests that cross lines are
split, one after the other; what a request causes at the next level is finished before anything else happens; a miss
sends its fetch, then the write itself if it goes through, then the victim's dirty sectors from the highest address
down (VictimOrder.WRITE_BACK_FIRST: these first).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, inlined
from archsim.model.cache.replacement import COMING, INVALID, NO_WAY, UNUSED, WAY, age, new_ages, use, victim
from archsim.model.cache.spec import MAX_SECTORS, CacheSpec, VictimOrder, WritePolicy
from archsim.model.compiled import record

_LEVEL = record(
    "first_set",  # where the level's sets begin among those of all levels
    "set_mask",
    "num_ways",
    "line_shift",
    "sector_shift",
    "replacement",
    "seed",
    "writes_through",
    "allocates_writes",
    "victim_order",
)
_REQUEST = record("level", "address", "bytes", "is_write")


class LevelCounts(NamedTuple):
    """What one level did. A request that crosses lines counts once for each line."""

    reads: int
    writes: int  # stores, write-backs and written-through writes from above
    read_misses: int  # reads that did not find all their sectors
    write_misses: int
    fetches: int  # reads sent to the next level
    writebacks: int  # runs of dirty sectors of victims, sent to the next level
    writethroughs: int  # writes sent on as they are
    bytes_read: int  # from the next level
    bytes_written: int  # to the next level


_COUNTS = record(*LevelCounts._fields)


class Chain(NamedTuple):
    """L levels, the first one asked, the memory behind the last; R sets of all levels, at most A ways a set.

    A is padded to LANES.
    """

    levels: np.ndarray  # _LEVEL [L]
    counts: np.ndarray  # _COUNTS [L + 1] the last for the memory
    uses: np.ndarray  # [L] requests looked up, the clock of LRU and FIFO
    last_way: np.ndarray  # [R] way that was used last
    tags: np.ndarray  # [R, A] line number or INVALID
    ages: np.ndarray  # [R, A] request that used the line last, see `victim`
    ways: np.ndarray  # WAY [R, A]; nothing is ever on its way
    pending: np.ndarray  # _REQUEST [P] a stack: the last one is handled next
    num_pending: np.ndarray  # [1]


def new_chain(caches: Sequence[CacheSpec]) -> Chain:
    """Empty caches, the first one asked, each the next level of the one before."""
    levels = np.zeros(len(caches), _LEVEL)
    for name in ("num_ways", "replacement", "seed", "allocates_writes", "victim_order"):
        levels[name] = [getattr(cache, name) for cache in caches]
    levels["set_mask"] = [cache.num_sets - 1 for cache in caches]
    levels["first_set"] = np.cumsum(levels["set_mask"] + 1) - levels["set_mask"] - 1
    levels["line_shift"] = [cache.line_bytes.bit_length() - 1 for cache in caches]
    levels["sector_shift"] = [cache.sector_bytes.bit_length() - 1 for cache in caches]
    levels["writes_through"] = [cache.write_policy == WritePolicy.WRITE_THROUGH for cache in caches]

    num_sets = sum(cache.num_sets for cache in caches)
    ages = new_ages(np.repeat(levels["num_ways"], levels["set_mask"] + 1))
    return Chain(
        levels=levels,
        counts=np.zeros(len(caches) + 1, _COUNTS),
        uses=np.zeros(len(caches), np.int64),
        last_way=np.zeros(num_sets, np.int64),
        tags=np.full(ages.shape, INVALID),
        ages=ages,
        ways=np.zeros(ages.shape, WAY),
        pending=np.zeros((len(caches) + 1) * (MAX_SECTORS // 2 + 3), _REQUEST),
        num_pending=np.zeros(1, np.int64),
    )


def counts_of(chain: Chain) -> list[LevelCounts]:
    """What every level has done so far; the last entry is the memory, with the reads and writes asked of it."""
    return [LevelCounts(*row) for row in chain.counts.tolist()]


@compiled
def replay(chain, addresses, sizes, writes):
    """Make requests one after the other: byte addresses (int64), bytes (int64, at least 1), whether it is a write."""
    for i in range(len(addresses)):
        _request(chain, 0, addresses[i], sizes[i], writes[i])
        _settle(chain)


@compiled
def copy_back(chain):
    """Write all dirty sectors down to the memory; lines stay. In the order of Dinero IV, which does so at its end."""
    for level in range(len(chain.levels)):
        one = chain.levels[level]
        for row in range(one["first_set"] + one["set_mask"], one["first_set"] - 1, -1):
            way = _next_in_time(one, chain.ages[row], UNUSED)
            while way != NO_WAY:
                _send_dirty(chain, level, row, way)
                _settle(chain)
                way = _next_in_time(one, chain.ages[row], chain.ages[row, way])


@inlined
def _next_in_time(one, ages, before):
    """The way whose line has the earliest time after `before`, or NO_WAY."""
    found, earliest = NO_WAY, COMING
    for number in range(one["num_ways"]):
        if before < ages[number] < earliest:
            found, earliest = number, ages[number]
    return found


@inlined
def _settle(chain):
    """Handle what is pending, the last request first."""
    while chain.num_pending[0] > 0:
        chain.num_pending[0] -= 1
        request = chain.pending[chain.num_pending[0]]
        level, address, num_bytes = request["level"], request["address"], request["bytes"]
        if level < len(chain.levels):
            _request(chain, level, address, num_bytes, request["is_write"])
        elif request["is_write"]:
            chain.counts[level]["writes"] += 1
        else:
            chain.counts[level]["reads"] += 1


@inlined
def _push(chain, level, address, num_bytes, is_write):
    """The request is handled before all that are pending."""
    place = chain.num_pending[0]
    chain.num_pending[0] = place + 1
    request = chain.pending[place]
    request["level"], request["address"], request["bytes"], request["is_write"] = (
        level,
        address,
        num_bytes,
        is_write,
    )


@inlined
def _request(chain, level, address, num_bytes, is_write):
    """Look up the part of the request that lies in its first line; the rest is pending, behind all that this causes."""
    one = chain.levels[level]
    line = address >> one["line_shift"]
    in_line = ((line + 1) << one["line_shift"]) - address
    if num_bytes > in_line:
        _push(chain, level, address + in_line, num_bytes - in_line, is_write)
        num_bytes = in_line

    row = one["first_set"] + (line & one["set_mask"])
    touched = _touched(one, address, num_bytes)
    way = _find(chain, one, row, line)
    chain.uses[level] += 1
    if is_write:
        chain.counts[level]["writes"] += 1
    else:
        chain.counts[level]["reads"] += 1
    if way != NO_WAY and touched & ~chain.ways[row, way]["present"] == 0:
        _use(chain, level, row, way)
        if is_write:
            _write_hit(chain, level, row, way, touched, address, num_bytes)
    else:
        _miss(chain, level, row, way, touched, address, num_bytes, is_write)


@inlined
def _touched(one, address, num_bytes):
    """Bit for each sector that the bytes, which are of one line, lie in."""
    if one["sector_shift"] == one["line_shift"]:
        return 1
    sector_mask = (1 << (one["line_shift"] - one["sector_shift"])) - 1
    first = address >> one["sector_shift"]
    num_sectors = ((address + num_bytes - 1) >> one["sector_shift"]) - first + 1
    return ((1 << num_sectors) - 1) << (first & sector_mask)


@inlined
def _find(chain, one, row, line):
    """The line's way, or NO_WAY."""
    last = chain.last_way[row]
    if chain.tags[row, last] == line:
        return last
    for way in range(one["num_ways"]):
        if chain.tags[row, way] == line:
            return way
    return NO_WAY


@inlined
def _use(chain, level, row, way):
    """The line was asked for."""
    chain.last_way[row] = way
    use(chain.levels[level], chain.ages, (row, way), chain.uses[level])


@inlined
def _write_hit(chain, level, row, way, touched, address, num_bytes):
    """The sectors that were written are dirty, or the write goes through."""
    if chain.levels[level]["writes_through"]:
        chain.counts[level]["writethroughs"] += 1
        _send(chain, level, address, num_bytes, 1)
    else:
        chain.ways[row, way]["dirty"] |= touched


@compiled
def _miss(chain, level, row, way, touched, address, num_bytes, is_write):
    """Sectors of the line are missing; `way` is the line's way, if it has one."""
    one = chain.levels[level]
    allocates = not is_write or one["allocates_writes"] != 0
    sector_address = address >> one["sector_shift"] << one["sector_shift"]
    sector_bytes = _count_bits(touched) << one["sector_shift"]
    if is_write:
        chain.counts[level]["write_misses"] += 1
    else:
        chain.counts[level]["read_misses"] += 1

    dirty_row, dirty_way = row, NO_WAY
    if way == NO_WAY and allocates:
        way = victim(one, chain.tags, chain.ages, row, chain.uses[level])
        dirty_way = way
    goes_through = is_write and (one["writes_through"] != 0 or way == NO_WAY)
    fetches = not is_write or (allocates and num_bytes < sector_bytes)

    if dirty_way != NO_WAY and one["victim_order"] == VictimOrder.FETCH_FIRST:
        _send_dirty(chain, level, dirty_row, dirty_way)
    if goes_through:
        chain.counts[level]["writethroughs"] += 1
        _send(chain, level, address, num_bytes, 1)
    if fetches:
        chain.counts[level]["fetches"] += 1
        _send(chain, level, sector_address, sector_bytes, 0)
    if dirty_way != NO_WAY and one["victim_order"] == VictimOrder.WRITE_BACK_FIRST:
        _send_dirty(chain, level, dirty_row, dirty_way)

    if dirty_way != NO_WAY:
        chain.tags[row, way] = address >> one["line_shift"]
        chain.ages[row, way] = age(chain.uses[level], way)
        chain.ways[row, way]["present"] = 0
    if way != NO_WAY:
        chain.ways[row, way]["present"] |= touched
        _use(chain, level, row, way)
        if is_write and not goes_through:
            chain.ways[row, way]["dirty"] |= touched


@inlined
def _send(chain, level, address, num_bytes, is_write):
    """A request to the next level, handled before all that are pending."""
    if is_write:
        chain.counts[level]["bytes_written"] += num_bytes
    else:
        chain.counts[level]["bytes_read"] += num_bytes
    _push(chain, level + 1, address, num_bytes, is_write)


@inlined
def _send_dirty(chain, level, row, way):
    """A write for each run of dirty sectors; the line is clean."""
    one = chain.levels[level]
    dirty = chain.ways[row, way]["dirty"]
    chain.ways[row, way]["dirty"] = 0
    first = 0
    while dirty >> first != 0:
        if dirty >> first & 1 == 0:
            first += 1
            continue
        last = first
        while dirty >> (last + 1) & 1 != 0:
            last += 1
        address = (chain.tags[row, way] << one["line_shift"]) + (first << one["sector_shift"])
        chain.counts[level]["writebacks"] += 1
        _send(chain, level, address, (last - first + 1) << one["sector_shift"], 1)
        first = last + 1


@inlined
def _count_bits(bits):
    number = 0
    while bits != 0:
        bits &= bits - 1
        number += 1
    return number
