"""A tree of caches with MSHRs and merging, compiled: what a lookup and a fill do to the lines.

Whom a request came from and where a fetch goes is the machine's business; here a requester is a number.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.model.cache import compiled_clear
from archsim.model.cache.replacement import INVALID, NO_WAY, WAY, use, victim
from archsim.model.cache.spec import DRAM_PARENT, MAX_SECTORS, CacheSpec, WritePolicy
from archsim.model.compiled import NEVER, QueueState, inlined_step, new_queues, record, step

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
    "supplier",  # the lowest level that answered one
    "free",  # entry of the cache's stack of free MSHRs
)
_CACHE_FIELDS = (
    "num_lookups",  # accepted requests, but CLEARs
    "fetch",  # MSHR of the last lookup, or NO_MSHR if nothing is fetched
    "victim",  # line replaced by the last lookup, or NO_LINE if none is to be written back
    "victim_dirty",  # its dirty sectors
    "passes_on",  # whether the last lookup's write goes to the next level
    "lookup_due",  # cycle of the next lookup, or NEVER
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
    """K caches, R sets of all caches, at most A ways a set and S sectors a line, M MSHRs a cache, T targets an MSHR."""

    caches: np.ndarray  # CACHE [K]
    tags: (
        np.ndarray
    )  # [R, A] line number if all of the line is present, else its complement; INVALID without a line
    ways: np.ndarray  # WAY [R, A]
    last_way: np.ndarray  # uint32 [R] way of the set that was used last
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
    num_sets = sum(int(mask) + 1 for mask in spec["set_mask"])
    mshrs = np.zeros((num_caches, num_mshrs), MSHR)
    mshrs["free"] = np.arange(num_mshrs)
    is_watched = np.zeros(num_caches + 1, np.bool_)
    is_watched[list(watched)] = True
    return CacheState(
        caches=owners,
        tags=np.full((num_sets, num_ways), INVALID),
        ways=np.zeros((num_sets, num_ways), WAY),
        last_way=np.zeros(num_sets, np.uint32),
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


@inlined_step
def _row_of(spec, line):
    """Set that the line belongs to, among those of all caches."""
    return spec["first_set"] + (line & spec["set_mask"])


@inlined_step
def _touched(spec, address, num_bytes):
    """Bit for each sector that the bytes, which are of one line, lie in."""
    if spec["sector_shift"] == spec["line_shift"]:
        return 1
    per_line = 1 << (spec["line_shift"] - spec["sector_shift"])
    first = address >> spec["sector_shift"]
    last = (address + num_bytes - 1) >> spec["sector_shift"]
    return ((1 << (last - first + 1)) - 1) << (first & (per_line - 1))


@inlined_step
def _use(spec, state, cache, request, place, outcome):
    """The request is accepted and uses the line at this place (set, way)."""
    row, number = place
    state.accepted[cache, request.kind, outcome] += 1
    state.caches[cache]["num_lookups"] += 1
    state.last_way[row] = number
    use(spec, state.ways[row, number], state.caches[cache]["num_lookups"])


@inlined_step
def hits(spec, state, cache, request):
    """Whether the line is all present and the request no more than a use of it; if so, it is accepted."""
    if spec[cache]["slow_kinds"] >> request.kind & 1:
        return False
    line = request.address >> spec[cache]["line_shift"]
    row = _row_of(spec[cache], line)
    if state.tags[row, state.last_way[row]] == line:
        _hit(spec[cache], state, cache, request, (row, state.last_way[row]))
        return True
    for way in range(spec[cache]["num_ways"]):
        if state.tags[row, way] == line:
            _hit(spec[cache], state, cache, request, (row, way))
            return True
    return False


@inlined_step
def _hit(spec, state, cache, request, place):
    _use(spec, state, cache, request, place, HIT)
    if request.kind != READ:
        state.ways[place]["dirty"] |= _touched(spec, request.address, request.bytes)


@step
def accept(spec, state, cycle, cache, request):
    """What any request meets in `cycle`. `fetch`, `victim` and `passes_on` of the cache say what to send."""
    one, owner = spec[cache], state.caches[cache]
    owner["fetch"], owner["victim"], owner["passes_on"] = NO_MSHR, NO_LINE, 0
    if request.kind == CLEAR:
        _clear(one, state, cache, request)
        return CLEARED

    line = request.address >> one["line_shift"]
    row = _row_of(one, line)
    touched = _touched(one, request.address, request.bytes)
    found = NO_WAY
    for number in range(one["num_ways"]):
        tag = state.tags[row, number]
        found = number if (tag == line) | (tag == ~line) else found
    if found != NO_WAY:
        way = state.ways[row, found]
        missing = touched & ~np.int64(way["present"])
        if missing == 0 or missing & way["coming"] != 0:
            return _meet(one, state, cycle, cache, request, (row, found), missing)
    return _miss(spec, state, cycle, cache, request, (row, found))


@inlined_step
def _meet(spec, state, cycle, cache, request, place, missing):
    """HIT if nothing is missing; MERGE if one fetch brings all that is, and a target is free; else REFUSED."""
    is_through = spec["writes_through"] != 0 and request.kind != READ
    if is_through and not _has_room(spec, state, cycle, cache):
        return REFUSED
    if missing != 0:
        number = state.fetching[place[0], place[1], _lowest(missing & state.ways[place]["coming"])]
        mshr = state.mshrs[cache, number]
        if missing & ~np.int64(mshr["sectors"]) != 0:
            return REFUSED
        if request.kind != WRITEBACK:
            if mshr["num_waiting"] == spec["num_targets"]:
                return REFUSED
            _add_target(state, cache, number, request.requester)
    outcome = HIT if missing == 0 else MERGE
    _use(spec, state, cache, request, place, outcome)
    _write(spec, state, cache, request, place)
    return outcome


@inlined_step
def _miss(spec, state, cycle, cache, request, place):
    """MISS, or REFUSED. The place has the line's way, or NO_WAY; nothing that is missing is on its way."""
    one, owner, (row, way) = spec[cache], state.caches[cache], place
    is_write, has_line = request.kind != READ, way != NO_WAY
    if is_write and not has_line and one["allocates_writes"] == 0:
        return _pass_on(one, state, cycle, cache, request)

    if not has_line:
        way = victim(one, state.tags, state.ways, row, owner["num_lookups"] + 1)
        if way == NO_WAY:
            return REFUSED
    wants_data = not is_write or (one["allocates_writes"] != 0 and not _covers(one, request))
    is_clear = wants_data and compiled_clear.is_clear(one, state.is_clear, *span(one, request))
    fetches = wants_data and not is_clear
    writes_back = not has_line and state.ways[row, way]["dirty"] != 0
    if fetches and owner["num_free"] == 0:
        return REFUSED
    if (writes_back or (is_write and one["writes_through"] != 0)) and not _has_room(one, state, cycle, cache):
        return REFUSED

    if not has_line:
        _replace(one, state, owner, (row, way), request)
    owner["clear_fills"] += is_clear
    touched = _touched(one, request.address, request.bytes)
    if fetches:
        mshr = _expect(one, state, cycle, cache, (row, way), touched)
        if request.kind != WRITEBACK:
            _add_target(state, cache, mshr, request.requester)
    else:
        _arrive(one, state, (row, way), touched)
    _use(one, state, cache, request, (row, way), MISS)
    _write(one, state, cache, request, (row, way))
    return MISS


@inlined_step
def _pass_on(spec, state, cycle, cache, request):
    """MISS of a write that leaves no line, or REFUSED."""
    owner = state.caches[cache]
    if not _has_room(spec, state, cycle, cache):
        return REFUSED
    state.accepted[cache, request.kind, MISS] += 1
    owner["num_lookups"] += 1
    owner["passes_on"] = 1
    return MISS


@inlined_step
def _has_room(spec, state, cycle, cache):
    """Whether one more write may be sent in `cycle`."""
    if spec["num_write_entries"] == 0:
        return True
    if spec["parent"] == DRAM_PARENT:
        return next_landing(spec, state, cache) <= cycle
    return state.caches[cache]["waiting_writes"] < spec["num_write_entries"]


@inlined_step
def next_landing(spec, state, cache):
    """When the write queue, all of it sent to the DRAM, has room for one more write; in the past if it has."""
    return state.landing[cache, state.caches[cache]["landing_writes"] % spec["num_write_entries"]]


@step
def remember_write(spec, state, cache, arrival):
    """A write was sent that reaches the next level in cycle `arrival`; the DRAM accepts it then."""
    owner = state.caches[cache]
    if spec["parent"] != DRAM_PARENT:
        owner["waiting_writes"] += 1
    elif spec["num_write_entries"] > 0:
        state.landing[cache, owner["landing_writes"] % spec["num_write_entries"]] = arrival
        owner["landing_writes"] += 1


@inlined_step
def _covers(spec, request):
    """Whether the request's bytes are all bytes of the sectors that they lie in."""
    return (request.address | request.bytes) & ((1 << spec["sector_shift"]) - 1) == 0


@inlined_step
def span(spec, request):
    """Address and bytes of the sectors that the request touches."""
    start = request.address >> spec["sector_shift"] << spec["sector_shift"]
    last = (request.address + request.bytes - 1) >> spec["sector_shift"]
    return start, ((last + 1) << spec["sector_shift"]) - start


@inlined_step
def _write(spec, state, cache, request, place):
    """A write makes its sectors dirty, or passes on."""
    if request.kind != READ:
        if spec["writes_through"] != 0:
            state.caches[cache]["passes_on"] = 1
        else:
            state.ways[place]["dirty"] |= _touched(spec, request.address, request.bytes)


@step
def _add_target(state, cache, mshr, requester):
    """The requester is answered when the MSHR's fetch is here."""
    position = state.mshrs[cache, mshr]["num_waiting"]
    state.targets[cache, mshr, position] = requester
    state.mshrs[cache, mshr]["num_waiting"] = position + 1


@step
def _replace(spec, state, owner, place, request):
    """The line at this place leaves, `victim` keeps it if it is dirty; the request's comes, with nothing present."""
    way, tag = state.ways[place], state.tags[place]
    if way["dirty"] != 0:
        owner["victim"] = max(tag, ~tag)
        owner["victim_dirty"] = way["dirty"]
    state.tags[place] = ~(request.address >> spec["line_shift"])
    way["used"] = owner["num_lookups"] + 1
    way["present"], way["dirty"] = 0, 0


@step
def _expect(spec, state, cycle, cache, place, touched):
    """A free MSHR becomes `fetch`, for sectors that are asked for `hit_cycles` after `cycle`."""
    owner = state.caches[cache]
    owner["num_free"] -= 1
    number = state.mshrs[cache, owner["num_free"]]["free"]
    mshr = state.mshrs[cache, number]
    mshr["set"], mshr["way"] = place
    mshr["sectors"] = touched
    mshr["arrival"] = cycle + spec["hit_cycles"]
    mshr["num_waiting"] = mshr["parts_left"] = mshr["supplier"] = 0
    owner["fetch"] = number
    state.ways[place]["coming"] |= touched
    for sector in range(1 << (spec["line_shift"] - spec["sector_shift"])):
        if touched >> sector & 1:
            state.fetching[place[0], place[1], sector] = number
    return number


@inlined_step
def _arrive(spec, state, place, sectors):
    """The sectors are present."""
    way, tag = state.ways[place], state.tags[place]
    way["present"] |= sectors
    if way["present"] == (1 << (1 << (spec["line_shift"] - spec["sector_shift"]))) - 1:
        state.tags[place] = max(tag, ~tag)


@step
def fill(spec, state, cycle, cache, number, supplier):
    """A part of the MSHR's fetch is here in `cycle`. True if it was the last; then the caller answers the targets."""
    owner, mshr = state.caches[cache], state.mshrs[cache, number]
    owner["fetch_cycles"] += cycle - mshr["arrival"]
    mshr["supplier"] = max(mshr["supplier"], supplier)
    mshr["parts_left"] -= 1
    if mshr["parts_left"] > 0:
        return False

    place = mshr["set"], mshr["way"]
    state.ways[place]["coming"] &= ~np.int64(mshr["sectors"])
    _arrive(spec[cache], state, place, mshr["sectors"])
    state.mshrs[cache, owner["num_free"]]["free"] = number
    owner["num_free"] += 1
    if owner["blocked_since"] != NOT_BLOCKED:
        owner["lookup_due"] = cycle
    return True


@inlined_step
def end_block(owner, cycle):
    """The refused request is tried again in `cycle`."""
    if owner["blocked_since"] != NOT_BLOCKED:
        owner["blocked"] += cycle - owner["blocked_since"]
        owner["blocked_since"] = NOT_BLOCKED


@step
def _clear(spec, state, cache, request):
    """The CLEAR is accepted: its blocks are known to be cleared, lines within them are dropped."""
    start, end = compiled_clear.set_bits(spec, state.is_clear, request.address, request.bytes)
    state.caches[cache]["clears"] += 1
    for row in range(spec["first_set"], spec["first_set"] + spec["set_mask"] + 1):
        for number in range(spec["num_ways"]):
            way, tag = state.ways[row, number], state.tags[row, number]
            first = max(tag, ~tag) << spec["line_shift"]
            is_within = start <= first and first + (1 << spec["line_shift"]) <= end
            if tag != INVALID and is_within and way["coming"] == 0:
                state.tags[row, number] = INVALID
                way["present"], way["dirty"] = 0, 0


@inlined_step
def _lowest(bits):
    """Number of the lowest bit that is set."""
    number = 0
    while bits >> number & 1 == 0:
        number += 1
    return number


@inlined_step
def highest_run(bits):
    """The highest run of bits that are set: the number of the first one, and of the first one behind it."""
    end = MAX_SECTORS
    while bits >> (end - 1) & 1 == 0:
        end -= 1
    first = end
    while first > 0 and bits >> (first - 1) & 1 != 0:
        first -= 1
    return first, end
