"""A tree of caches with MSHRs, merging and write-back, compiled: what a lookup and a fill do to the lines.

Whom a request came from and where a fetch goes is the machine's business; here a requester is a number.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.model.cache.spec import CacheSpec
from archsim.model.fifo.compiled import NEVER, QueueState, new_queues

READ, WRITE, WRITEBACK = range(3)  # kinds of a request, columns of `kinds`
HIT, MERGE, MISS, REFUSED = range(4)  # what a lookup returns; the first three are columns of `outcomes`
NO_LINE = -1
NO_MSHR = -1
NOT_BLOCKED = -1
_INVALID = np.iinfo(np.int64).min

WAITING = np.dtype([(name, np.int64) for name in ("arrival", "rank", "address", "kind", "requester")])


class Request(NamedTuple):
    """What a cache is asked. A WRITEBACK's requester is the child cache."""

    address: int
    kind: int  # READ, WRITE or WRITEBACK
    requester: int


class CacheTable(NamedTuple):
    """The specs of K caches by column, each an array [K]; see CacheSpec."""

    set_mask: np.ndarray
    num_ways: np.ndarray
    line_shift: np.ndarray
    hit_cycles: np.ndarray
    num_mshrs: np.ndarray
    num_targets: np.ndarray
    num_ports: np.ndarray
    parent: np.ndarray
    first_way: np.ndarray  # where the cache's ways begin among those of all caches


class CacheState(NamedTuple):
    """K caches, V ways of all caches, at most M MSHRs a cache, T targets an MSHR."""

    tags: np.ndarray  # [V] line number if present, its complement if on its way, _INVALID if there is none
    used: np.ndarray  # [V] the cache's lookup that used the way last, 0 for never
    dirty: np.ndarray  # [V] whether the line differs from the next level
    mshr_of: np.ndarray  # [V] MSHR of a line on its way
    lookups: np.ndarray  # [K] accepted requests so far
    way_of: np.ndarray  # [K, M] way that waits for the MSHR's line
    arrival: np.ndarray  # [K, M] cycle in which the fetch reaches the next level
    targets: np.ndarray  # [K, M, T] requesters that wait for the line
    num_waiting: np.ndarray  # [K, M] of them
    free: np.ndarray  # [K, M] stack of free MSHRs
    num_free: np.ndarray  # [K] of them
    fetch: np.ndarray  # [K] MSHR of the last miss, or NO_MSHR if nothing is fetched
    victim: np.ndarray  # [K] dirty line replaced by the last miss, or NO_LINE
    inbox: QueueState  # [K] requests sent and not yet accepted
    lookup_due: np.ndarray  # [K] cycle of the next lookup, or NEVER
    blocked_since: np.ndarray  # [K] first cycle in which the oldest request was refused, or NOT_BLOCKED
    kinds: np.ndarray  # [K, 3] accepted requests by kind
    outcomes: np.ndarray  # [K, 3] accepted requests by outcome
    fetches: np.ndarray  # [K]
    writebacks_out: np.ndarray  # [K]
    blocked: np.ndarray  # [K] cycles, without those since `blocked_since`
    fetch_cycles: np.ndarray  # [K] from `arrival` to the fill, summed


def cache_table(caches: Sequence[CacheSpec]) -> CacheTable:
    """The specs by column."""

    def column(values: Sequence[int]) -> np.ndarray:
        return np.array(values, np.int64)

    num_ways = [cache.num_sets * cache.num_ways for cache in caches]
    return CacheTable(
        set_mask=column([cache.num_sets - 1 for cache in caches]),
        num_ways=column([cache.num_ways for cache in caches]),
        line_shift=column([cache.line_bytes.bit_length() - 1 for cache in caches]),
        hit_cycles=column([cache.hit_cycles for cache in caches]),
        num_mshrs=column([cache.num_mshrs for cache in caches]),
        num_targets=column([cache.num_targets for cache in caches]),
        num_ports=column([cache.num_ports for cache in caches]),
        parent=column([cache.parent for cache in caches]),
        first_way=np.concatenate([[0], np.cumsum(num_ways)]).astype(np.int64),
    )


def new_caches(spec: CacheTable, inbox_capacity: int) -> CacheState:
    """All lines invalid, all MSHRs free, nothing asked."""
    num_caches, num_ways = len(spec.num_ways), int(spec.first_way[-1])
    num_mshrs, num_targets = max(spec.num_mshrs, default=0), max(spec.num_targets, default=0)

    def table(*shape: int, value: int = 0) -> np.ndarray:
        return np.full(shape, value, np.int64)

    return CacheState(
        tags=table(num_ways, value=_INVALID),
        used=table(num_ways),
        dirty=np.zeros(num_ways, np.bool_),
        mshr_of=table(num_ways, value=NO_MSHR),
        lookups=table(num_caches),
        way_of=table(num_caches, num_mshrs),
        arrival=table(num_caches, num_mshrs),
        targets=table(num_caches, num_mshrs, num_targets),
        num_waiting=table(num_caches, num_mshrs),
        free=np.tile(np.arange(num_mshrs), (num_caches, 1)),
        num_free=spec.num_mshrs.copy(),
        fetch=table(num_caches, value=NO_MSHR),
        victim=table(num_caches, value=NO_LINE),
        inbox=new_queues(num_caches, inbox_capacity, WAITING),
        lookup_due=table(num_caches, value=NEVER),
        blocked_since=table(num_caches, value=NOT_BLOCKED),
        kinds=table(num_caches, 3),
        outcomes=table(num_caches, 3),
        fetches=table(num_caches),
        writebacks_out=table(num_caches),
        blocked=table(num_caches),
        fetch_cycles=table(num_caches),
    )


@njit(forceinline=True)
def _first_way(spec, cache, line):
    """First way of the line's set."""
    return spec.first_way[cache] + (line & spec.set_mask[cache]) * spec.num_ways[cache]


@njit(forceinline=True)
def _use(state, cache, request, way, outcome):
    """The request is accepted: its line is the most recently used, and dirty if written."""
    state.kinds[cache, request.kind] += 1
    state.outcomes[cache, outcome] += 1
    state.lookups[cache] += 1
    state.used[way] = state.lookups[cache]
    if request.kind != READ:
        state.dirty[way] = True


@njit(forceinline=True)
def hits(spec, state, cache, request):
    """Whether the line is present; if so, the request is accepted."""
    line = request.address >> spec.line_shift[cache]
    first = _first_way(spec, cache, line)
    for way in range(first, first + spec.num_ways[cache]):
        if state.tags[way] == line:
            _use(state, cache, request, way, HIT)
            return True
    return False


@njit
def accept_absent(spec, state, cycle, cache, request):
    """MERGE, MISS (then `fetch` and `victim` say what to send) or REFUSED for a line that is not present in `cycle`."""
    line = request.address >> spec.line_shift[cache]
    first = _first_way(spec, cache, line)
    victim = NO_LINE
    for way in range(first, first + spec.num_ways[cache]):
        tag = state.tags[way]
        if tag == ~line:
            return _merge(spec, state, cache, request, way)
        replaceable = tag >= 0 or tag == _INVALID
        if replaceable and (victim == NO_LINE or state.used[way] < state.used[victim]):
            victim = way

    is_whole = request.kind == WRITEBACK and spec.line_shift[request.requester] == spec.line_shift[cache]
    if victim == NO_LINE or (state.num_free[cache] == 0 and not is_whole):
        return REFUSED

    _replace(spec, state, cache, victim)
    if is_whole:
        state.tags[victim] = line
        state.fetch[cache] = NO_MSHR
    else:
        state.tags[victim] = ~line
        _expect(spec, state, cycle, cache, victim)
        if request.kind != WRITEBACK:
            _add_target(state, cache, state.fetch[cache], request.requester)
    _use(state, cache, request, victim, MISS)
    return MISS


@njit
def _merge(spec, state, cache, request, way):
    """MERGE the request with the fetch of the way's line, or REFUSED."""
    if request.kind != WRITEBACK:
        mshr = state.mshr_of[way]
        if state.num_waiting[cache, mshr] == spec.num_targets[cache]:
            return REFUSED
        _add_target(state, cache, mshr, request.requester)
    _use(state, cache, request, way, MERGE)
    return MERGE


@njit
def _add_target(state, cache, mshr, requester):
    """The requester is answered when the MSHR's line is here."""
    state.targets[cache, mshr, state.num_waiting[cache, mshr]] = requester
    state.num_waiting[cache, mshr] += 1


@njit
def _replace(spec, state, cache, way):
    """The way's line leaves; `victim` keeps it if it is dirty."""
    state.victim[cache] = NO_LINE
    if state.dirty[way]:
        state.victim[cache] = state.tags[way]
        state.writebacks_out[cache] += 1
    state.dirty[way] = False


@njit
def _expect(spec, state, cycle, cache, way):
    """A free MSHR becomes `fetch`, for the line that the way waits for from `cycle` on."""
    state.num_free[cache] -= 1
    mshr = state.free[cache, state.num_free[cache]]
    state.way_of[cache, mshr] = way
    state.mshr_of[way] = mshr
    state.num_waiting[cache, mshr] = 0
    state.arrival[cache, mshr] = cycle + spec.hit_cycles[cache]
    state.fetch[cache] = mshr
    state.fetches[cache] += 1


@njit
def fill(state, cycle, cache, mshr):
    """The MSHR's line is here in `cycle`; its targets are to be answered by the caller. A refused request tries again."""
    way = state.way_of[cache, mshr]
    state.tags[way] = ~state.tags[way]
    state.free[cache, state.num_free[cache]] = mshr
    state.num_free[cache] += 1
    state.fetch_cycles[cache] += cycle - state.arrival[cache, mshr]

    if state.blocked_since[cache] != NOT_BLOCKED:
        state.blocked[cache] += cycle - state.blocked_since[cache]
        state.blocked_since[cache] = NOT_BLOCKED
        state.lookup_due[cache] = cycle
