"""A tree of caches with MSHRs, merging and write-back, compiled: what a lookup and a fill do to the lines.

Whom a request came from and where a fetch goes is the machine's business; here a requester is a number.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.model.cache.spec import CacheSpec
from archsim.model.compiled import NEVER, QueueState, inlined_step, new_queues, record, step

READ, WRITE, WRITEBACK = range(3)  # kinds of a request
HIT, MERGE, MISS, REFUSED = range(
    4
)  # what a lookup returns; the first three are outcomes of accepted requests
NO_LINE = -1
NO_WAY = -1
NO_MSHR = -1
NOT_BLOCKED = -1
_INVALID = np.iinfo(np.int64).min


class Request(NamedTuple):
    """What a cache is asked. A WRITEBACK's requester is the child cache."""

    address: int
    kind: int  # READ, WRITE or WRITEBACK
    requester: int


_SPEC_INDICES = (
    "set_mask",
    "line_shift",
    "hit_cycles",
    "num_mshrs",
    "num_targets",
    "num_ports",
    "first_set",  # where the cache's sets begin among those of all caches
)
_WAY_FIELDS = (
    "used",  # the cache's lookup that used the way last, 0 for never
    "is_dirty",  # whether the line differs from the next level
)
_MSHR_INDICES = (
    "set",  # and
    "way",  # that wait for the line
    "num_waiting",  # targets
    "free",  # entry of the cache's stack of free MSHRs
)
_CACHE_FIELDS = (
    "num_lookups",  # accepted requests
    "fetch",  # MSHR of the last miss, or NO_MSHR if nothing is fetched
    "victim",  # dirty line replaced by the last miss, or NO_LINE
    "lookup_due",  # cycle of the next lookup, or NEVER
    "blocked_since",  # first cycle in which the oldest request was refused, or NOT_BLOCKED
    "fetches",  # lines asked for
    "writebacks_out",  # dirty victims
    "blocked",  # cycles, without those since `blocked_since`
    "fetch_cycles",  # from `arrival` to the fill, summed
)
CACHE_SPEC = record("parent", "num_ways", indices=_SPEC_INDICES)
WAY = record(*_WAY_FIELDS, indices=("mshr",))  # the MSHR of a line on its way
MSHR = record("arrival", indices=_MSHR_INDICES)  # cycle in which the fetch reaches the next level
CACHE = record(*_CACHE_FIELDS, indices=("num_free",))  # free MSHRs
WAITING = record("arrival", "rank", *Request._fields)


class CacheState(NamedTuple):
    """K caches, R sets of all caches, at most A ways a set, M MSHRs a cache, T targets an MSHR."""

    caches: np.ndarray  # CACHE [K]
    tags: np.ndarray  # [R, A] line number if present, its complement if on its way, _INVALID if there is none
    ways: np.ndarray  # WAY [R, A]
    last_way: np.ndarray  # uint32 [R] way of the set that was used last
    mshrs: np.ndarray  # MSHR [K, M]
    targets: np.ndarray  # [K, M, T] requesters that wait for the line
    inbox: QueueState  # WAITING [K] requests sent and not yet accepted
    accepted: np.ndarray  # [K, 3, 3] requests by kind and outcome


def cache_table(caches: Sequence[CacheSpec]) -> np.ndarray:
    """CACHE_SPEC [K]: the specs as the compiled functions want them."""
    table = np.zeros(len(caches), CACHE_SPEC)
    for name in ("num_ways", "hit_cycles", "num_mshrs", "num_targets", "num_ports", "parent"):
        table[name] = [getattr(cache, name) for cache in caches]
    table["set_mask"] = [cache.num_sets - 1 for cache in caches]
    table["line_shift"] = [cache.line_bytes.bit_length() - 1 for cache in caches]
    num_sets = table["set_mask"] + 1
    table["first_set"] = np.cumsum(num_sets) - num_sets
    return table


def new_caches(spec: np.ndarray, inbox_capacity: int) -> CacheState:
    """All lines invalid, all MSHRs free, nothing asked."""
    num_caches = len(spec)
    widths = [int(spec[name].max(initial=0)) for name in ("num_ways", "num_mshrs", "num_targets")]
    num_ways, num_mshrs, num_targets = widths

    caches = np.zeros(num_caches, CACHE)
    caches["num_free"] = spec["num_mshrs"]
    caches["lookup_due"] = NEVER
    caches["blocked_since"] = NOT_BLOCKED
    num_sets = sum(int(mask) + 1 for mask in spec["set_mask"])
    mshrs = np.zeros((num_caches, num_mshrs), MSHR)
    mshrs["free"] = np.arange(num_mshrs)
    return CacheState(
        caches=caches,
        tags=np.full((num_sets, num_ways), _INVALID),
        ways=np.zeros((num_sets, num_ways), WAY),
        last_way=np.zeros(num_sets, np.uint32),
        mshrs=mshrs,
        targets=np.zeros((num_caches, num_mshrs, num_targets), np.int64),
        inbox=new_queues(num_caches, inbox_capacity, WAITING),
        accepted=np.zeros((num_caches, 3, 3), np.int64),
    )


@inlined_step
def _row_of(spec, line):
    """Set that the line belongs to, among those of all caches."""
    return spec["first_set"] + (line & spec["set_mask"])


@inlined_step
def _use(state, cache, request, place, outcome):
    """The request is accepted: the line at this place (set, way) is the most recently used, and dirty if written."""
    row, number = place
    state.accepted[cache, request.kind, outcome] += 1
    state.caches[cache]["num_lookups"] += 1
    state.last_way[row] = number
    way = state.ways[row, number]
    way["used"] = state.caches[cache]["num_lookups"]
    if request.kind != READ:
        way["is_dirty"] = 1


@inlined_step
def hits(spec, state, cache, request):
    """Whether the line is present; if so, the request is accepted."""
    line = request.address >> spec[cache]["line_shift"]
    row = _row_of(spec[cache], line)
    if state.tags[row, state.last_way[row]] == line:
        _use(state, cache, request, (row, state.last_way[row]), HIT)
        return True
    for way in range(spec[cache]["num_ways"]):
        if state.tags[row, way] == line:
            _use(state, cache, request, (row, way), HIT)
            return True
    return False


@step
def accept_absent(spec, state, cycle, cache, request):
    """MERGE, MISS (then `fetch` and `victim` say what to send) or REFUSED for a line that is not present in `cycle`."""
    line = request.address >> spec[cache]["line_shift"]
    row = _row_of(spec[cache], line)
    coming, victim, oldest = NO_WAY, NO_WAY, NEVER
    for way in range(spec[cache]["num_ways"]):
        tag, used = state.tags[row, way], state.ways[row, way]["used"]
        is_older = (used < oldest) & ((tag >= 0) | (tag == _INVALID))
        coming = way if tag == ~line else coming
        victim = way if is_older else victim
        oldest = used if is_older else oldest
    if coming != NO_WAY:
        return _merge(spec, state, cache, request, (row, coming))

    is_whole = (
        request.kind == WRITEBACK and spec[request.requester]["line_shift"] == spec[cache]["line_shift"]
    )
    if victim == NO_WAY or (state.caches[cache]["num_free"] == 0 and not is_whole):
        return REFUSED

    _replace(state, state.caches[cache], (row, victim))
    state.tags[row, victim] = line
    if not is_whole:
        state.tags[row, victim] = ~line
        mshr = _expect(state, cycle + spec[cache]["hit_cycles"], cache, (row, victim))
        if request.kind != WRITEBACK:
            _add_target(state, cache, mshr, request.requester)
    _use(state, cache, request, (row, victim), MISS)
    return MISS


@step
def _merge(spec, state, cache, request, place):
    """MERGE the request with the fetch of the line at this place, or REFUSED."""
    if request.kind != WRITEBACK:
        mshr = state.ways[place]["mshr"]
        if state.mshrs[cache, mshr]["num_waiting"] == spec[cache]["num_targets"]:
            return REFUSED
        _add_target(state, cache, mshr, request.requester)
    _use(state, cache, request, place, MERGE)
    return MERGE


@step
def _add_target(state, cache, mshr, requester):
    """The requester is answered when the MSHR's line is here."""
    position = state.mshrs[cache, mshr]["num_waiting"]
    state.targets[cache, mshr, position] = requester
    state.mshrs[cache, mshr]["num_waiting"] = position + 1


@step
def _replace(state, cache, place):
    """The line at this place leaves; `victim` keeps it if it is dirty."""
    cache["fetch"] = NO_MSHR
    cache["victim"] = NO_LINE
    if state.ways[place]["is_dirty"] != 0:
        cache["victim"] = state.tags[place]
        cache["writebacks_out"] += 1
    state.ways[place]["is_dirty"] = 0


@step
def _expect(state, arrival, cache, place):
    """A free MSHR becomes `fetch`, for a line that is asked for at the next level in cycle `arrival`."""
    owner = state.caches[cache]
    owner["num_free"] -= 1
    owner["fetches"] += 1
    number = state.mshrs[cache, owner["num_free"]]["free"]
    mshr = state.mshrs[cache, number]
    mshr["set"], mshr["way"] = place
    mshr["arrival"] = arrival
    mshr["num_waiting"] = 0
    owner["fetch"] = number
    state.ways[place]["mshr"] = number
    return number


@step
def fill(state, cycle, cache, number):
    """The MSHR's line is here in `cycle`; the caller answers its targets. A refused request tries again."""
    owner, mshr = state.caches[cache], state.mshrs[cache, number]
    place = mshr["set"], mshr["way"]
    state.tags[place] = ~state.tags[place]
    state.mshrs[cache, owner["num_free"]]["free"] = number
    owner["num_free"] += 1
    owner["fetch_cycles"] += cycle - mshr["arrival"]

    if owner["blocked_since"] != NOT_BLOCKED:
        owner["blocked"] += cycle - owner["blocked_since"]
        owner["blocked_since"] = NOT_BLOCKED
        owner["lookup_due"] = cycle
