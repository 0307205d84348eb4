"""A tree of caches with MSHRs and merging, compiled: what a lookup and a fill do to the lines.

Whom a request came from and where a fetch goes is the machine's business; here a requester is a number.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import bit_length, lowest_bit
from archsim.lanes import LANES, equal_lanes
from archsim.model.cache import compiled_clear
from archsim.model.cache.compiled_state import (
    CLEAR,
    CLEARED,
    HIT,
    MERGE,
    MISS,
    NO_LINE,
    NO_MSHR,
    NOT_BLOCKED,
    READ,
    REFUSED,
    WRITEBACK,
)
from archsim.model.cache.replacement import COMING, INVALID, NO_WAY, age, use, victim
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.causes import AtCache
from archsim.model.compiled import inlined_step, step

_TARGET, _WAY, _MSHR, _WRITE_QUEUE = (
    int(cause) for cause in (AtCache.TARGET, AtCache.WAY, AtCache.MSHR, AtCache.WRITE_QUEUE)
)


@inlined_step
def _row_of(spec, line):
    """Set that the line belongs to, among those of all caches."""
    return np.uint32(spec["first_set"] + (line & spec["set_mask"]))


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
    use(spec, state.ages, (row, number), state.caches[cache]["num_lookups"])


@inlined_step
def find(spec, state, cache, request):
    """Set and way of the request's line; NO_WAY if neither it nor a part of it is here or on its way."""
    line = request.address >> spec[cache]["line_shift"]
    row = _row_of(spec[cache], line)
    for first in range(0, spec[cache]["num_ways"], LANES):
        found = equal_lanes(state.tags, row, first, line, ~line)
        if found != 0:
            return row, first + lowest_bit(found)
    return row, NO_WAY


@inlined_step
def hits(spec, state, cache, request, place):
    """Whether the line, at this place, is all present and the request no more than a use of it: then it is accepted."""
    line = request.address >> spec[cache]["line_shift"]
    if place[1] == NO_WAY or spec[cache]["slow_kinds"] >> request.kind & 1:
        return False
    place = place[0], np.uint32(place[1])
    if state.tags[place] != line:
        return False
    _use(spec[cache], state, cache, request, place, HIT)
    if request.kind != READ:
        state.ways[place]["dirty"] |= _touched(spec[cache], request.address, request.bytes)
    return True


@step
def accept(spec, state, cycle, cache, request, place):
    """What any request, whose line is at this place, meets in `cycle`.

    `fetch`, `victim` and `passes_on` of the cache say what to send.
    """
    one, owner = spec[cache], state.caches[cache]
    owner["fetch"], owner["victim"], owner["passes_on"] = NO_MSHR, NO_LINE, 0
    if request.kind == CLEAR:
        _clear(one, state, cache, request)
        return CLEARED

    touched = _touched(one, request.address, request.bytes)
    if place[1] != NO_WAY:
        way = state.ways[place]
        missing = touched & ~np.int64(way["present"])
        if missing == 0 or missing & way["coming"] != 0:
            return _meet(one, state, cycle, cache, request, place, missing)
    return _miss(spec, state, cycle, cache, request, place)


@inlined_step
def _meet(spec, state, cycle, cache, request, place, missing):
    """HIT if nothing is missing; MERGE if one fetch brings all that is, and a target is free; else REFUSED."""
    owner, mshr = state.caches[cache], np.int64(NO_MSHR)
    if missing != 0:
        mshr = np.int64(state.fetching[place[0], place[1], lowest_bit(missing & state.ways[place]["coming"])])
        is_full = state.mshrs[cache, mshr]["num_waiting"] == spec["num_targets"] and request.kind != WRITEBACK
        if is_full or missing & ~np.int64(state.mshrs[cache, mshr]["sectors"]) != 0:
            return _refuse(owner, _TARGET)
    is_through = spec["writes_through"] != 0 and request.kind != READ
    if is_through and not _has_room(spec, state, cycle, cache):
        return _refuse(owner, _WRITE_QUEUE)

    if mshr != NO_MSHR and request.kind != WRITEBACK:
        _add_target(state, cache, mshr, request.requester)
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
        way = victim(one, state.tags, state.ages, row, owner["num_lookups"] + 1)
        if way == NO_WAY:
            return _refuse(owner, _WAY)
    wants_data = not is_write or (one["allocates_writes"] != 0 and not _covers(one, request))
    is_clear = wants_data and compiled_clear.is_clear(one, state.is_clear, *span(one, request))
    fetches = wants_data and not is_clear
    writes_back = not has_line and state.ways[row, way]["dirty"] != 0
    if fetches and owner["num_free"] == 0:
        return _refuse(owner, _MSHR)
    if (writes_back or (is_write and one["writes_through"] != 0)) and not _has_room(one, state, cycle, cache):
        return _refuse(owner, _WRITE_QUEUE)

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
def _refuse(owner, lack):
    """REFUSED, for want of this."""
    owner["lack"] = lack
    return REFUSED


@inlined_step
def _pass_on(spec, state, cycle, cache, request):
    """MISS of a write that leaves no line, or REFUSED."""
    owner = state.caches[cache]
    if not _has_room(spec, state, cycle, cache):
        return _refuse(owner, _WRITE_QUEUE)
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
    state.ages[place] = age(owner["num_lookups"] + 1, place[1])
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
    mshr["num_waiting"] = mshr["parts_left"] = 0
    owner["fetch"] = number
    state.ways[place]["coming"] |= touched
    state.ages[place] |= COMING
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
def fill(spec, state, cycle, cache, number):
    """A part of the MSHR's fetch is here in `cycle`. True if it was the last; then the caller answers the targets."""
    owner, mshr = state.caches[cache], state.mshrs[cache, number]
    owner["fetch_cycles"] += cycle - mshr["arrival"]
    mshr["parts_left"] -= 1
    if mshr["parts_left"] > 0:
        return False

    place = mshr["set"], mshr["way"]
    coming = state.ways[place]["coming"] & ~np.int64(mshr["sectors"])
    state.ways[place]["coming"] = coming
    if coming == 0:
        state.ages[place] &= ~COMING
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
        owner["refused_until"] = cycle
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
                state.tags[row, number], state.ages[row, number] = INVALID, age(0, number)
                way["present"], way["dirty"] = 0, 0


@inlined_step
def highest_run(bits):
    """The highest run of bits that are set: the number of the first one, and of the first one behind it."""
    end = bit_length(bits)
    return bit_length(~bits & ((1 << end) - 1)), end
