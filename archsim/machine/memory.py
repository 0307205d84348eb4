"""The memory side of the compiled machine: requests, lookups, answers and fills.

A requester is a thread (its number, from 0 up) or the MSHR of a child cache (below 0).
"""

from __future__ import annotations

import numpy as np

from archsim.machine import waits
from archsim.machine.counters import STALL_MEMORY
from archsim.machine.state import Machine, State
from archsim.machine.waits import IN_PARTS, LOOKUP_HIT
from archsim.model import compiled as queue_model
from archsim.model.cache import arbitration, compiled_clear
from archsim.model.cache import compiled as cache_model
from archsim.model.cache.compiled_state import (
    CLEAR,
    HIT,
    MERGE,
    MISS,
    NO_LINE,
    NO_MSHR,
    NOT_BLOCKED,
    READ,
    REFUSED,
    WRITE,
    WRITEBACK,
    Request,
)
from archsim.model.cache.spec import DRAM_PARENT, Arbiter, VictimOrder
from archsim.model.causes import AT_CACHE, AtCache
from archsim.model.compiled import NEVER, inlined_step, step
from archsim.model.core import compiled_turns as turns
from archsim.model.dram import compiled as dram_model

_LOOKUP = int(AtCache.LOOKUP)
_PART = 1 << 48  # what the requester number of a fetch's next part is less


@inlined_step
def access(spec: Machine, state: State, cycle, core, request):
    """A core asks its cache. A cache that only this core talks to can look at once: nobody else comes in `cycle`."""
    cache = spec.core_cache[core]
    if state.cache.watched[cache] and request.kind != CLEAR:
        see(state, cycle, request.requester, request)
    at_once = spec.is_private[cache] and queue_model.num_items(state.cache.inbox, cache) == 0
    if not (at_once and _accept(spec, state, cycle, cache, request) != REFUSED):
        put(spec, state, cycle, cache, core, request)


@inlined_step
def look_up_due(spec: Machine, state: State, cycle):
    """Play the lookups of `cycle` and find out when the next one is; whom a cache sends to comes after it.

    One loop, not one for each cache's ports: that would prepare for all that can happen at a lookup.
    """
    caches, run = state.cache.caches, state.run[0]
    cache, num_done, next_lookup = 0, 0, NEVER
    run["next_lookup"] = NEVER
    while cache < len(caches):
        due = caches[cache]["lookup_due"]
        if due <= cycle:
            num_done += 1
            _look_up(spec, state, cycle, np.uint32(cache), num_done == spec.caches[cache]["num_ports"])
        else:
            next_lookup = min(next_lookup, due)
            cache, num_done = cache + 1, 0
    run["next_lookup"] = min(run["next_lookup"], next_lookup)


@inlined_step
def _look_up(spec, state, cycle, cache, is_last):
    """The cache looks up its next request in `cycle`, the last one for which it has a port if `is_last`.

    One has arrived: a lookup is due only when a request comes, or when one that was refused may be accepted.
    """
    inbox, owner, one = state.cache.inbox, state.cache.caches[cache], spec.caches[cache]
    cache_model.end_block(owner, cycle)
    position = 0
    if one["arbiter"] != Arbiter.ARRIVAL:
        position = arbitration.chosen(one, owner, inbox, cache, cycle)
    waiting = inbox.items[cache, queue_model.slot_of(inbox, cache, position)]
    request = Request(waiting["address"], waiting["bytes"], waiting["kind"], waiting["requester"])
    outcome = _accept(spec, state, cycle, cache, request)
    if outcome == REFUSED:
        owner["blocked_since"] = cycle
        owner["lookup_due"] = _next_try(spec, state, cycle, cache)
        return
    if waiting["arrival"] < cycle and request.kind != WRITEBACK:
        _note_accepted(spec, state, cycle, cache, (waiting, outcome))
    owner["last_sender"] = waiting["rank"]
    if position == 0:
        queue_model.drop_oldest(inbox, cache)
    else:
        queue_model.remove(inbox, cache, position)

    due = NEVER
    if queue_model.num_items(inbox, cache) > 0:
        due = max(queue_model.oldest(inbox, cache)["arrival"], cycle + 1 if is_last else cycle)
    owner["lookup_due"] = due


@step
def _note_accepted(spec, state, cycle, cache, accepted):
    """The cache accepts in `cycle` a request that had to wait; accepted: it, and what the lookup returned."""
    owner, (waiting, outcome) = state.cache.caches[cache], accepted
    requester, arrival = waiting["requester"], waiting["arrival"]
    if requester >= 0:
        state.waits.threads[requester]["asked"] = arrival
        if outcome == HIT:
            waits.count_latency(state.waits, cache, cycle + spec.caches[cache]["hit_cycles"] - arrival)
        state.core.threads[requester]["reason"] = IN_PARTS
        waits.note_accepted(state.waits.threads[requester], owner, arrival, cycle)
    else:
        child, _, mshr = mshr_of(requester)
        waits.note_accepted(state.waits.fetches[child, mshr], owner, arrival, cycle)


@step
def _next_try(spec, state, cycle, cache):
    """When a request that was refused in `cycle` is tried again, unless a fill or a write accepted comes before."""
    one, due = spec.caches[cache], NEVER
    if one["arbiter"] != Arbiter.ARRIVAL:
        due = arbitration.next_choice(state.cache.inbox, cache, cycle)
    if one["num_write_entries"] > 0 and one["parent"] == DRAM_PARENT:
        room = cache_model.next_landing(one, state.cache, cache)
        due = min(due, room) if room > cycle else due
    return due


@inlined_step
def _accept(spec, state, cycle, cache, request):
    """HIT if the cache answers the request of `cycle` by itself, else MISS, or REFUSED; sends what follows from it."""
    place = cache_model.find(spec.caches, state.cache, cache, request)
    if cache_model.hits(spec.caches, state.cache, cache, request, place):
        if request.kind == WRITEBACK:
            _take_write(state, cycle, request.requester)
        else:
            _answer_hit(state, cycle + spec.caches[cache]["hit_cycles"], cache, request.requester)
        return HIT
    return _accept_otherwise(spec, state, cycle, cache, request, place)


@step
def _accept_otherwise(spec, state, cycle, cache, request, place):
    """The same for a request that is more than a use of a line that is present."""
    outcome = cache_model.accept(spec.caches, state.cache, cycle, cache, request, place)
    if outcome == REFUSED:
        return REFUSED
    is_answered, arrival = False, cycle + spec.caches[cache]["hit_cycles"]
    if request.kind == WRITEBACK:
        _take_write(state, cycle, request.requester)
    elif outcome != MERGE and state.cache.caches[cache]["fetch"] == NO_MSHR:
        _answer_hit(state, arrival, cache, request.requester)
        is_answered = True
    elif request.requester >= 0:
        state.waits.threads[request.requester]["asked"] = cycle

    fetch_first = spec.caches[cache]["victim_order"] == VictimOrder.FETCH_FIRST
    if not fetch_first:
        send_victim(spec, state, arrival, cache)
    _send_fetch(spec, state, arrival, cache, request)
    if state.cache.caches[cache]["passes_on"] != 0:
        parts = _send_write(spec, state, arrival, cache, request.address, request.bytes)
        state.cache.caches[cache]["writethroughs_out"] += parts
    if fetch_first:
        send_victim(spec, state, arrival, cache)
    return HIT if is_answered else MISS


@inlined_step
def _send_fetch(spec, state, arrival, cache, request):
    """The fetch of the last lookup, if there is one, to arrive in cycle `arrival`."""
    owner = state.cache.caches[cache]
    mshr = owner["fetch"]
    if mshr != NO_MSHR:
        address, num_bytes = cache_model.span(spec.caches[cache], request)
        fetch = Request(address, num_bytes, READ, _fetcher(cache, mshr))
        parts, sent_bytes = _send(spec, state, arrival, cache, fetch)
        state.cache.mshrs[cache, mshr]["parts_left"] = parts
        owner["fetches"] += parts
        owner["fetched_bytes"] += sent_bytes


@inlined_step
def send_victim(spec, state, arrival, cache):
    """The dirty sectors of the line that the last lookup replaced, a write for each run, the highest address first."""
    owner = state.cache.caches[cache]
    dirty = owner["victim_dirty"] if owner["victim"] != NO_LINE else 0
    start = owner["victim"] << spec.caches[cache]["line_shift"]
    while dirty != 0:
        first, end = cache_model.highest_run(dirty)
        dirty &= (1 << first) - 1
        shift = spec.caches[cache]["sector_shift"]
        parts = _send_write(spec, state, arrival, cache, start + (first << shift), (end - first) << shift)
        owner["writebacks_out"] += parts


@step
def _send_write(spec, state, arrival, cache, address, num_bytes):
    """A write that wants no answer, to arrive in cycle `arrival`; the number of requests that it takes."""
    owner = state.cache.caches[cache]
    compiled_clear.reset(spec.caches[cache], state.cache.is_clear, address, num_bytes)
    parts, sent_bytes = _send(spec, state, arrival, cache, Request(address, num_bytes, WRITEBACK, cache))
    owner["written_bytes"] += sent_bytes
    for _ in range(parts):
        cache_model.remember_write(spec.caches[cache], state.cache, cache, arrival)
    return parts


@step
def _take_write(state, cycle, child):
    """A write of the child cache is accepted in `cycle`; from the next one on the child has room for one more."""
    owner = state.cache.caches[child]
    owner["waiting_writes"] -= 1
    if owner["blocked_since"] != NOT_BLOCKED:
        owner["lookup_due"] = min(owner["lookup_due"], cycle + 1)
        state.run[0]["next_lookup"] = min(state.run[0]["next_lookup"], cycle + 1)


@inlined_step
def _answer_hit(state, arrival, cache, requester):
    """The requester of a hit gets its answer in cycle `arrival`."""
    if requester >= 0:
        thread = state.core.threads[requester]
        thread["reason"] = STALL_MEMORY + AT_CACHE * cache + _LOOKUP
        turns.wake_at(state.core, arrival, requester)
    else:
        answer_fetch(state, arrival, cache, requester)


@step
def answer_fetch(state, arrival, level, requester):
    """A fetch is answered in cycle `arrival` by a cache, or by the DRAM if the level's number is behind theirs."""
    kind = 1 if level == len(state.cache.caches) else 0
    slot = queue_model.insert(state.answers, kind, arrival, level)
    state.answers.items[kind, slot]["requester"] = requester
    state.run[0]["next_answer"] = min(state.run[0]["next_answer"], arrival)


@step
def see(state, arrival, sender, request):
    """Note a request that reaches a place that is watched; ask for room long before there is none."""
    seen = state.cache.seen[state.cache.num_seen[0]]
    seen["cycle"], seen["address"], seen["bytes"] = arrival, request.address, request.bytes
    seen["requester"], seen["is_write"] = sender, request.kind != READ
    state.cache.num_seen[0] += 1
    if 2 * state.cache.num_seen[0] > len(state.cache.seen):
        state.run[0]["needs_room"] = 1
        state.run[0]["horizon"] = 0


@step
def _send(spec, state, arrival, cache, request):
    """Send a request that reaches the next level in cycle `arrival`, in parts as that one wants; (parts, bytes)."""
    one = spec.caches[cache]
    end = request.address + request.bytes
    start, parts = request.address, 0
    each = _PART if request.kind == READ else 0
    if one["parent"] == DRAM_PARENT:
        grain = one["grain_shift"]
        start, end = start >> grain << grain, (((end - 1) >> grain) + 1) << grain
        whole = Request(start, end - start, request.kind, request.requester)
        if state.cache.watched[DRAM_PARENT]:
            see(state, arrival, cache, whole)
        _send_to_dram(spec, state, arrival, cache, whole)
        return 1, end - start
    while start < end:
        stop = min(((start >> one["cut_shift"]) + 1) << one["cut_shift"], end)
        part = Request(start, stop - start, request.kind, request.requester - parts * each)
        if state.cache.watched[one["parent"]]:
            see(state, arrival, cache, part)
        put(spec, state, arrival, one["parent"], spec.core.num_cores + cache, part)
        start = stop
        parts += 1
    return parts, request.bytes


@step
def _send_to_dram(spec, state, arrival, cache, request):
    """A request of whole bursts reaches the DRAM in cycle `arrival`."""
    arrival_ticks, is_write = arrival * spec.core.period_ticks, request.kind == WRITEBACK
    queued = dram_model.send(spec.dram, state.dram, arrival_ticks, request.address, cache, is_write)
    queued["bursts"] = request.bytes >> spec.caches[cache]["grain_shift"]
    queued["requester"] = request.requester
    ring = dram_model.ring_of_request(spec.dram, request.address, is_write)
    _look_after(spec, state, state.dram.queue, ring)


@step
def access_dram(spec: Machine, state: State, cycle, rank, bursts, request):
    """A requester asks the DRAM without a cache; `rank`, below 0, orders those of one cycle, before the caches."""
    ticks, is_write = cycle * spec.core.period_ticks, request.kind == WRITE
    queued = dram_model.send(spec.dram, state.dram, ticks, request.address, rank, is_write)
    queued["bursts"] = bursts
    queued["requester"] = _fetcher(len(spec.caches), request.requester)
    state.waits.threads[request.requester]["asked"] = cycle
    ring = dram_model.ring_of_request(spec.dram, request.address, is_write)
    _look_after(spec, state, state.dram.queue, ring)


@step
def put(spec, state, arrival, cache, rank, request):
    """A request reaches the cache in cycle `arrival`; `rank` orders those of one cycle."""
    inbox = state.cache.inbox
    slot = queue_model.insert(inbox, cache, arrival, rank)
    waiting = inbox.items[cache, slot]
    waiting["address"] = request.address
    waiting["bytes"] = request.bytes
    waiting["kind"] = request.kind
    waiting["requester"] = request.requester
    receiver = state.cache.caches[cache]
    if receiver["blocked_since"] == NOT_BLOCKED or spec.caches[cache]["arbiter"] != Arbiter.ARRIVAL:
        receiver["lookup_due"] = min(receiver["lookup_due"], arrival)
        state.run[0]["next_lookup"] = min(state.run[0]["next_lookup"], arrival)
    state.run[0]["horizon"] = min(state.run[0]["horizon"], arrival)
    _look_after(spec, state, inbox, cache)


@step
def _look_after(spec, state, queues, q):
    """Ask for room if what a cycle may add no longer fits into queue `q`."""
    run = state.run[0]
    if queue_model.num_items(queues, q) + spec.spare_slots > queues.items.shape[1]:
        run["needs_room"] = 1
        run["horizon"] = 0


@inlined_step
def _fetcher(cache, mshr):
    """Requester number of a cache's MSHR."""
    return ~(cache << 32 | mshr)


@inlined_step
def mshr_of(requester):
    """Cache, part of the fetch, and MSHR of a requester number below 0."""
    return ~requester >> 32 & 0xFFFF, ~requester >> 48, ~requester & 0xFFFFFFFF


@inlined_step
def deliver_due(spec: Machine, state: State, cycle):
    """Hand the answers of `cycle` to those who fetched, and find out when the next one arrives."""
    answers = state.answers
    next_answer = NEVER
    for kind in range(len(answers.ends)):
        while queue_model.num_items(answers, kind) > 0:
            answer = queue_model.oldest(answers, kind)
            if answer["arrival"] > cycle:
                next_answer = min(next_answer, answer["arrival"])
                break
            state.filling[0] = answer["requester"]
            _fill_tree(spec, state, cycle)
            queue_model.drop_oldest(answers, kind)
    state.run[0]["next_answer"] = next_answer


@step
def _fill_tree(spec, state, cycle):
    """Fill the fetch that `filling` begins with, in its cache and wherever it is waited for below, in `cycle`."""
    num_filling = 1
    state.sources[0] = LOOKUP_HIT
    while num_filling > 0:
        num_filling -= 1
        cache, part, mshr = mshr_of(state.filling[num_filling])
        if cache == len(state.cache.caches):  # asked of the DRAM without a cache
            _wake(state, cycle, cache, mshr)
            continue
        wait = state.waits.fetches[cache, mshr]
        parent = spec.caches[cache]["parent"]
        level = parent if parent != DRAM_PARENT else len(spec.caches)
        waits.count_latency(state.waits, level, cycle - state.cache.mshrs[cache, mshr]["arrival"])
        waits.note_answered(wait, cycle, part, state.sources[num_filling])
        if not cache_model.fill(spec.caches, state.cache, cycle, cache, mshr):
            continue
        state.run[0]["next_lookup"] = min(
            state.run[0]["next_lookup"], state.cache.caches[cache]["lookup_due"]
        )
        for i in range(state.cache.mshrs[cache, mshr]["num_waiting"]):
            requester = state.cache.targets[cache, mshr, i]
            if requester < 0:
                state.filling[num_filling] = requester
                state.sources[num_filling] = mshr
                num_filling += 1
            else:
                state.waits.threads[requester]["source"] = mshr
                _wake(state, cycle, cache, requester)


@inlined_step
def _wake(state, cycle, level, number):
    """The data that the thread asked of this level is here: it is ready in `cycle`."""
    thread = state.core.threads[number]
    waits.count_latency(state.waits, level, cycle - state.waits.threads[number]["asked"])
    thread["reason"] = IN_PARTS
    turns.wake_now(state.core, cycle, number)
