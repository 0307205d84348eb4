"""The state of the compiled caches: lines, MSHRs, queues, and the specs as the compiled functions want them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.model.cache import compiled_clear
from archsim.model.cache.replacement import INVALID, WAY, new_ages
from archsim.model.cache.spec import DRAM_PARENT, CacheSpec, WritePolicy
from archsim.model.compiled import NEVER, QueueState, new_queues, record

READ, WRITE, WRITEBACK, CLEAR = range(4)  # kinds of a request
HIT, MERGE, MISS, CLEARED, REFUSED = range(5)  # what a lookup returns; only REFUSED requests are not accepted
NO_LINE = -1
NO_MSHR = -1
NOT_BLOCKED = -1


class Request(NamedTuple):
    """What a cache is asked. A WRITEBACK's requester is the child cache."""

    address: int
    bytes: int  # all in one line, but for CLEAR
    kind: int  # READ, WRITE, WRITEBACK or CLEAR
    requester: int


_SPEC_INDICES = (
    "set_mask",
    "line_shift",
    "sector_shift",
    "hit_cycles",
    "num_mshrs",
    "num_targets",
    "num_ports",
    "first_set",  # where the cache's sets begin among those of all caches
    "first_block",  # where its clear bits begin among those of all caches
    "slow_kinds",  # bit for each kind of request that is more than a use of its line even if that is present
)
_SPEC_FIELDS = (
    "parent",
    "num_ways",
    "replacement",
    "seed",
    "writes_through",
    "allocates_writes",
    "victim_order",
    "num_write_entries",
    "arbiter",
    "clear_shift",  # log2 of the bytes of a block with a clear bit, or NO_CLEAR
    "clear_start",  # address of the first block
    "num_blocks",
    "cut_shift",  # log2 of the bytes that what it sends is cut at: the parent's line
    "grain_shift",  # log2 of the bytes that what it sends is rounded out to: the DRAM's burst
)
_MSHR_INDICES = (
    "set",  # and
    "way",  # that wait for
    "sectors",  # bit for each
    "num_waiting",  # targets
    "parts_left",  # requests to the next level that are not answered
    "free",  # entry of the cache's stack of free MSHRs
)
_CACHE_FIELDS = (
    "num_lookups",  # accepted requests, but CLEARs
    "fetch",  # MSHR of the last lookup, or NO_MSHR if nothing is fetched
    "victim",  # line replaced by the last lookup, or NO_LINE if none is to be written back
    "victim_dirty",  # its dirty sectors
    "passes_on",  # whether the last lookup's write goes to the next level
    "lookup_due",  # cycle of the next lookup, or NEVER
    "lack",  # AtCache: what the last refused request lacked
    "refused_until",  # cycle behind the last one in which a request was refused
    "blocked_since",  # cycle in which a request was refused that has not been tried again, or NOT_BLOCKED
    "last_sender",  # of the last accepted request
    "waiting_writes",  # sent and not accepted by the next level, if that is a cache
    "landing_writes",  # sent to the DRAM, all in all
    "clears",  # CLEARs accepted
    "clear_fills",  # misses filled without a fetch because memory is known to be cleared
    "fetches",  # reads sent
    "writebacks_out",  # writes of victims sent
    "writethroughs_out",  # other writes sent
    "fetched_bytes",
    "written_bytes",
    "blocked",  # cycles, without those since `blocked_since`
    "fetch_cycles",  # from `arrival` to the answer, summed over the reads sent
)
CACHE_COUNTS = (
    *("clears", "clear_fills", "fetches", "writebacks_out", "writethroughs_out"),
    *("fetched_bytes", "written_bytes"),
)
CACHE_SPEC = record(*_SPEC_FIELDS, indices=_SPEC_INDICES)
MSHR = record("arrival", indices=_MSHR_INDICES)  # cycle in which the fetch reaches the next level
CACHE = record(*_CACHE_FIELDS, indices=("num_free",))  # free MSHRs
WAITING = record("arrival", "rank", *Request._fields)


SEEN = record("cycle", "address", "bytes", "requester", "is_write")
SEEN_AT_ONCE = 1 << 16  # requests that are kept until they are told


class CacheState(NamedTuple):
    """K caches, R sets of all caches, at most A ways a set and S sectors a line, M MSHRs a cache, T targets an MSHR.

    A' is A, padded to LANES.
    """

    caches: np.ndarray  # CACHE [K]
    tags: (
        np.ndarray
    )  # [R, A'] line number if all of the line is present, else its complement; INVALID without a line
    ages: np.ndarray  # [R, A'] see `victim`
    ways: np.ndarray  # WAY [R, A]
    fetching: np.ndarray  # uint32 [R, A, S] MSHR of a sector on its way
    mshrs: np.ndarray  # MSHR [K, M]
    targets: np.ndarray  # [K, M, T] requesters that wait for the fetch
    landing: np.ndarray  # [K, W] arrival of the last W writes sent to the DRAM, a ring
    is_clear: np.ndarray  # bool [blocks of all caches] whether the block is known to be cleared
    inbox: QueueState  # WAITING [K] requests sent and not yet accepted
    accepted: np.ndarray  # [K, 3, 3] requests by kind and outcome
    watched: np.ndarray  # bool [K + 1] caches, and at last the DRAM, whose requests are told
    seen: np.ndarray  # SEEN [L] requests that reached them, in the order in which they were sent
    num_seen: np.ndarray  # [1]


def cache_table(caches: Sequence[CacheSpec], burst_bytes: int) -> np.ndarray:
    """CACHE_SPEC [K]: the specs as the compiled functions want them."""
    table = np.zeros(len(caches), CACHE_SPEC)
    for name in set(CacheSpec._fields) & {*_SPEC_INDICES, *_SPEC_FIELDS}:
        table[name] = [getattr(cache, name) for cache in caches]
    table["set_mask"] = [cache.num_sets - 1 for cache in caches]
    table["line_shift"] = [_log2(cache.line_bytes) for cache in caches]
    table["sector_shift"] = [_log2(cache.sector_bytes) for cache in caches]
    table["writes_through"] = [cache.write_policy == WritePolicy.WRITE_THROUGH for cache in caches]
    table["slow_kinds"] = 1 << CLEAR | table["writes_through"] * (1 << WRITE | 1 << WRITEBACK)
    parents = [caches[cache.parent] if cache.parent >= 0 else None for cache in caches]
    table["cut_shift"] = [_log2(parent.line_bytes) if parent else 62 for parent in parents]
    table["grain_shift"] = [0 if parent else _log2(burst_bytes) for parent in parents]
    num_sets = table["set_mask"] + 1
    table["first_set"] = np.cumsum(num_sets) - num_sets
    compiled_clear.fill_in(table, [cache.clear for cache in caches])
    return table


def most_sent(caches: Sequence[CacheSpec]) -> int:
    """Requests that the lookups of a cycle may send: a fetch, a write that passes on and the runs of a victim each."""
    sent = 0
    for cache in caches:
        parts = _most_parts(caches, cache)
        sent += cache.num_ports * (2 * parts + max(parts, (cache.num_sectors + 1) // 2))
    return sent


def most_fetches(caches: Sequence[CacheSpec]) -> int:
    """Requests for all that can be on its way."""
    return sum(cache.num_mshrs * _most_parts(caches, cache) for cache in caches)


def least_bursts(caches: Sequence[CacheSpec], burst_bytes: int) -> int:
    """Bursts of the smallest fetch from the DRAM: a sector."""
    sectors = [cache.sector_bytes for cache in caches if cache.parent == DRAM_PARENT]
    return max(1, min(sectors, default=0) // burst_bytes)


def _most_parts(caches: Sequence[CacheSpec], cache: CacheSpec) -> int:
    """Requests that a line of the cache may take at the next level."""
    if cache.parent == DRAM_PARENT:
        return 1
    return max(1, cache.line_bytes // caches[cache.parent].line_bytes)


def _log2(number: int) -> int:
    return number.bit_length() - 1


def new_caches(
    spec: np.ndarray, caches: Sequence[CacheSpec], inbox_capacity: int, watched: Sequence[int] = ()
) -> CacheState:
    """All lines invalid, all MSHRs free, nothing asked."""
    num_caches = len(spec)
    widths = [int(spec[name].max(initial=0)) for name in ("num_ways", "num_mshrs", "num_targets")]
    num_ways, num_mshrs, num_targets = widths
    num_sectors = max((cache.num_sectors for cache in caches), default=1)

    owners = np.zeros(num_caches, CACHE)
    owners["num_free"] = spec["num_mshrs"]
    owners["lookup_due"] = NEVER
    owners["blocked_since"] = NOT_BLOCKED
    owners["last_sender"] = -1
    ages = new_ages(np.repeat(spec["num_ways"], spec["set_mask"] + np.int64(1)))
    num_sets = len(ages)
    mshrs = np.zeros((num_caches, num_mshrs), MSHR)
    mshrs["free"] = np.arange(num_mshrs)
    is_watched = np.zeros(num_caches + 1, np.bool_)
    is_watched[list(watched)] = True
    return CacheState(
        caches=owners,
        tags=np.full(ages.shape, INVALID),
        ages=ages,
        ways=np.zeros((num_sets, num_ways), WAY),
        fetching=np.zeros((num_sets, num_ways, num_sectors), np.uint32),
        mshrs=mshrs,
        targets=np.zeros((num_caches, num_mshrs, num_targets), np.int64),
        landing=np.zeros((num_caches, int(spec["num_write_entries"].max(initial=0))), np.int64),
        is_clear=compiled_clear.new_bits([cache.clear for cache in caches]),
        inbox=new_queues(num_caches, inbox_capacity, WAITING),
        accepted=np.zeros((num_caches, 3, 3), np.int64),
        watched=is_watched,
        seen=np.zeros(SEEN_AT_ONCE if watched else 0, SEEN),
        num_seen=np.zeros(1, np.int64),
    )
