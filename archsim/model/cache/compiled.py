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


_SPEC_FIELDS = (
    "set_mask",
    "num_ways",
    "line_shift",
    "hit_cycles",
    "num_mshrs",
    "num_targets",
    "num_ports",
    "parent",
    "first_set",  # where the cache's sets begin among those of all caches
)
_WAY_FIELDS = (
    "tag",  # line number if present, its complement if on its way, _INVALID if there is none
    "used",  # the cache's lookup that used the way last, 0 for never
    "is_dirty",  # whether the line differs from the next level
    "mshr",  # of a line on its way
)
_MSHR_FIELDS = (
    "set",  # and
    "way",  # that wait for the line
    "arrival",  # cycle in which the fetch reaches the next level
    "num_waiting",  # targets
    "free",  # entry of the cache's stack of free MSHRs
)
_CACHE_FIELDS = (
    "num_lookups",  # accepted requests
    "num_free",  # free MSHRs
    "fetch",  # MSHR of the last miss, or NO_MSHR if nothing is fetched
    "victim",  # dirty line replaced by the last miss, or NO_LINE
    "lookup_due",  # cycle of the next lookup, or NEVER
    "blocked_since",  # first cycle in which the oldest request was refused, or NOT_BLOCKED
    "fetches",  # lines asked for
    "writebacks_out",  # dirty victims
    "blocked",  # cycles, without those since `blocked_since`
    "fetch_cycles",  # from `arrival` to the fill, summed
)
CACHE_SPEC = record(*_SPEC_FIELDS)
WAY = record(*_WAY_FIELDS)
MSHR = record(*_MSHR_FIELDS)
CACHE = record(*_CACHE_FIELDS)
WAITING = record("arrival", "rank", *Request._fields)


class CacheState(NamedTuple):
    """K caches, R sets of all caches, at most A ways a set, M MSHRs a cache, T targets an MSHR."""

    caches: np.ndarray  # CACHE [K]
    ways: np.ndarray  # WAY [R, A]
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
    ways = np.zeros((int((spec["set_mask"] + 1).sum()), num_ways), WAY)
    ways["tag"] = _INVALID
    mshrs = np.zeros((num_caches, num_mshrs), MSHR)
    mshrs["free"] = np.arange(num_mshrs)
    return CacheState(
        caches=caches,
        ways=ways,
        mshrs=mshrs,
        targets=np.zeros((num_caches, num_mshrs, num_targets), np.int64),
        inbox=new_queues(num_caches, inbox_capacity, WAITING),
        accepted=np.zeros((num_caches, 3, 3), np.int64),
    )


@inlined_step
def _use(state, cache, request, way, outcome):
    """The request is accepted: its line is the most recently used, and dirty if written."""
    state.accepted[cache, request.kind, outcome] += 1
    state.caches[cache]["num_lookups"] += 1
    way["used"] = state.caches[cache]["num_lookups"]
    if request.kind != READ:
        way["is_dirty"] = 1


@inlined_step
def hits(spec, state, cache, request):
    """Whether the line is present; if so, the request is accepted."""
    line = request.address >> spec[cache]["line_shift"]
    row = spec[cache]["first_set"] + (line & spec[cache]["set_mask"])
    hit = NO_WAY
    for way in range(spec[cache]["num_ways"]):  # without a way out: where a line lies cannot be predicted
        hit = way if state.ways[row, way]["tag"] == line else hit
    if hit == NO_WAY:
        return False
    _use(state, cache, request, state.ways[row, hit], HIT)
    return True


@step
def accept_absent(spec, state, cycle, cache, request):
    """MERGE, MISS (then `fetch` and `victim` say what to send) or REFUSED for a line that is not present in `cycle`."""
    line = request.address >> spec[cache]["line_shift"]
    row = spec[cache]["first_set"] + (line & spec[cache]["set_mask"])
    coming, victim, oldest = NO_WAY, NO_WAY, NEVER
    for way in range(spec[cache]["num_ways"]):
        tag, used = state.ways[row, way]["tag"], state.ways[row, way]["used"]
        is_older = (used < oldest) & ((tag >= 0) | (tag == _INVALID))
        coming = way if tag == ~line else coming
        victim = way if is_older else victim
        oldest = used if is_older else oldest
    if coming != NO_WAY:
        return _merge(spec, state, cache, request, state.ways[row, coming])

    is_whole = (
        request.kind == WRITEBACK and spec[request.requester]["line_shift"] == spec[cache]["line_shift"]
    )
    if victim == NO_WAY or (state.caches[cache]["num_free"] == 0 and not is_whole):
        return REFUSED

    way = state.ways[row, victim]
    _replace(state.caches[cache], way)
    way["tag"] = line
    if not is_whole:
        way["tag"] = ~line
        way["mshr"] = _expect(state, cycle + spec[cache]["hit_cycles"], cache, row, victim)
        if request.kind != WRITEBACK:
            _add_target(state, cache, way["mshr"], request.requester)
    _use(state, cache, request, way, MISS)
    return MISS


@step
def _merge(spec, state, cache, request, way):
    """MERGE the request with the fetch of the way's line, or REFUSED."""
    if request.kind != WRITEBACK:
        if state.mshrs[cache, way["mshr"]]["num_waiting"] == spec[cache]["num_targets"]:
            return REFUSED
        _add_target(state, cache, way["mshr"], request.requester)
    _use(state, cache, request, way, MERGE)
    return MERGE


@step
def _add_target(state, cache, mshr, requester):
    """The requester is answered when the MSHR's line is here."""
    position = state.mshrs[cache, mshr]["num_waiting"]
    state.targets[cache, mshr, position] = requester
    state.mshrs[cache, mshr]["num_waiting"] = position + 1


@step
def _replace(cache, way):
    """The way's line leaves; `victim` keeps it if it is dirty."""
    cache["fetch"] = NO_MSHR
    cache["victim"] = NO_LINE
    if way["is_dirty"] != 0:
        cache["victim"] = way["tag"]
        cache["writebacks_out"] += 1
    way["is_dirty"] = 0


@step
def _expect(state, arrival, cache, row, way):
    """A free MSHR becomes `fetch`, for a line that is asked for at the next level in cycle `arrival`."""
    owner = state.caches[cache]
    owner["num_free"] -= 1
    owner["fetches"] += 1
    number = state.mshrs[cache, owner["num_free"]]["free"]
    mshr = state.mshrs[cache, number]
    mshr["set"] = row
    mshr["way"] = way
    mshr["arrival"] = arrival
    mshr["num_waiting"] = 0
    owner["fetch"] = number
    return number


@step
def fill(state, cycle, cache, number):
    """The MSHR's line is here in `cycle`; the caller answers its targets. A refused request tries again."""
    owner, mshr = state.caches[cache], state.mshrs[cache, number]
    way = state.ways[mshr["set"], mshr["way"]]
    way["tag"] = ~way["tag"]
    state.mshrs[cache, owner["num_free"]]["free"] = number
    owner["num_free"] += 1
    owner["fetch_cycles"] += cycle - mshr["arrival"]

    if owner["blocked_since"] != NOT_BLOCKED:
        owner["blocked"] += cycle - owner["blocked_since"]
        owner["blocked_since"] = NOT_BLOCKED
        owner["lookup_due"] = cycle
