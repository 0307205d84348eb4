"""The main loop of the compiled machine: phases of one core cycle, and the jump to the next one that matters.

Time is counted in core cycles. The order of what meets in one cycle is README.md's: fills, source, issue, lookups;
then the DRAM plays the memory clocks that lie before the next cycle visited.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, inlined
from archsim.machine.counters import STALL_LOCK, STALL_SUPPLIER
from archsim.machine.loading import Loaded
from archsim.model.cache import compiled as cache_model
from archsim.model.cache.compiled import (
    MISS,
    NO_LINE,
    NO_MSHR,
    NOT_BLOCKED,
    READ,
    REFUSED,
    WRITE,
    WRITEBACK,
    CacheState,
    Request,
)
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.core import compiled as core_model
from archsim.model.core.compiled import NO_TASK, NO_THREAD, CoreState
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.dram import compiled as dram_model
from archsim.model.dram.compiled import NO_REQUESTER, DramState
from archsim.model.dram.spec import DramSpec
from archsim.model.fifo import compiled as fifo_model
from archsim.model.fifo.compiled import NEVER, FifoState, QueueState
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks import compiled as locks_model
from archsim.model.locks.compiled import NOBODY, NOT_HOLDER, LocksState
from archsim.model.unit import compiled as unit_model
from archsim.model.unit.compiled import SourceState
from archsim.model.unit.spec import UnitSpec
from archsim.trace.records import Op

RUNNING, OVER, NEEDS_TASKS, NEEDS_ROOM, BAD_UNLOCK = range(5)  # why `play` returns

ANSWER = np.dtype([(name, np.int64) for name in ("arrival", "rank", "requester")], align=True)


class Machine(NamedTuple):
    """MachineSpec as the loop wants it: plain integers and arrays of one type, so that one compilation serves all."""

    core: CoreSpec
    source: UnitSpec
    fifo: FifoSpec
    caches: np.ndarray  # CACHE_SPEC [K]
    dram: DramSpec
    core_cache: np.ndarray  # [C] cache of the core
    is_private: np.ndarray  # [K] whether one core and nobody else talks to the cache
    bursts: np.ndarray  # [K] DRAM bursts of the cache's line
    spare_slots: int  # free slots that a queue needs at the beginning of a cycle


_RUN_FIELDS = (
    "cycle",  # being played; the last one when the run is over
    "next_core",  # first core that has not issued in it
    "next_answer",  # when the first answer on its way arrives
    "next_lookup",  # when the first cache has a request to look up
    "finished",  # tasks
    "last_finish",  # when the last of them was finished
    "last_clock",  # last memory clock at which a channel was woken
    "needs_room",  # whether a queue may overflow in the next cycle
    "culprit",  # thread that unlocked what it did not hold
)
RUN = np.dtype([(name, np.int64) for name in _RUN_FIELDS], align=True)  # times in core cycles


class State(NamedTuple):
    """Everything that changes during a run."""

    core: CoreState
    locks: LocksState
    source: SourceState
    fifo: FifoState
    cache: CacheState
    dram: DramState
    answers: QueueState  # [K + H] fetches answered by cache k, then by channel h
    filling: np.ndarray  # [MSHRs] fetches being filled in this cycle
    tasks: Loaded
    run: np.ndarray  # RUN [1]


@compiled
def play(spec, state):
    """Play until the work is over or the caller must help; the status says which."""
    cycle = state.run[0]["cycle"]
    while cycle != NEVER:
        state.run[0]["cycle"] = cycle
        _fill_due(spec, state, cycle)
        core_model.wake_due(state.core, cycle)
        _make_task(spec, state, cycle)
        for core in range(state.run[0]["next_core"], spec.core.num_cores):
            status = _issue(spec, state, cycle, core)
            if status != RUNNING:
                state.run[0]["next_core"] = core
                return status
        state.run[0]["next_core"] = 0
        _look_up_due(spec, state, cycle)

        cycle = _next_cycle(spec, state, cycle)
        if state.run[0]["needs_room"] != 0 and cycle != NEVER:
            state.run[0]["cycle"] = cycle
            return NEEDS_ROOM
    _play_last_tick(spec, state)
    return OVER


# ---- phase 0: fills, then the source ----


@inlined
def _fill_due(spec, state, cycle):
    """Deliver the answers that arrive in `cycle`."""
    if state.run[0]["next_answer"] <= cycle:
        _deliver(spec, state, cycle)


@compiled
def _deliver(spec, state, cycle):
    """Hand the answers of `cycle` to those who fetched, and find out when the next one arrives."""
    answers = state.answers
    num_caches = len(spec.bursts)
    next_answer = NEVER
    for sender in range(len(answers.ends)):
        while fifo_model.num_items(answers, sender) > 0:
            answer = fifo_model.oldest(answers, sender)
            if answer["arrival"] > cycle:
                next_answer = min(next_answer, answer["arrival"])
                break
            state.filling[0] = answer["requester"]
            _fill_tree(state, cycle, min(sender, num_caches))
            fifo_model.remove(answers, sender, 0)
    state.run[0]["next_answer"] = next_answer


@compiled
def _fill_tree(state, cycle, supplier):
    """Fill the line that `filling` begins with, in its cache and wherever it is waited for below, in `cycle`."""
    num_filling = 1
    while num_filling > 0:
        num_filling -= 1
        cache, mshr = _mshr_of(state.filling[num_filling])
        cache_model.fill(state.cache, cycle, cache, mshr)
        state.run[0]["next_lookup"] = min(
            state.run[0]["next_lookup"], state.cache.caches[cache]["lookup_due"]
        )
        for i in range(state.cache.mshrs[cache, mshr]["num_waiting"]):
            requester = state.cache.targets[cache, mshr, i]
            if requester < 0:
                state.filling[num_filling] = requester
                num_filling += 1
            else:
                thread = state.core.threads[requester]
                thread["reason"] = STALL_SUPPLIER + supplier
                core_model.wake_now(state.core, thread)


@inlined
def _make_task(spec, state, cycle):
    """The source makes at most one task in `cycle`."""
    if _source_due(spec, state) <= cycle:
        _make_one(spec, state, cycle)


@inlined
def _source_due(spec, state):
    """Cycle in which the source can make a task as things stand, or NEVER."""
    if state.fifo.ends[1] == state.tasks.num_tasks:
        return NEVER
    if core_model.num_idle(state.core) > 0 or fifo_model.has_room(spec.fifo, state.fifo):
        return state.source.ready[0]
    return NEVER


@compiled
def _make_one(spec, state, cycle):
    """The source makes a task in `cycle`, for the longest idle thread or for the fifo."""
    task = state.fifo.ends[1]
    state.fifo.ends[1] = task + 1
    unit_model.start_interval(spec.source, state.source, cycle)
    if core_model.num_idle(state.core) > 0:
        state.fifo.ends[0] = task + 1
        core_model.hand_to_idle(state.core, task)
    if task + 1 == state.tasks.num_tasks:
        core_model.retire_idle(state.core)


# ---- phase 1: issue ----


@inlined
def _issue(spec, state, cycle, core):
    """The core issues at most one instruction in `cycle`."""
    while True:
        place = core_model.pick(state.core, core)
        if place == NO_THREAD:
            return RUNNING
        number = core * spec.core.num_threads + place
        thread = state.core.threads[number]
        if thread["compute_left"] > 0:
            thread["compute_left"] -= 1
            core_model.count_issue(spec.core, state.core, cycle, thread)
            return RUNNING
        if thread["op"] != Op.END:
            core_model.count_issue(spec.core, state.core, cycle, thread)
            return _operate(spec, state, cycle, number)
        status = _change_task(spec, state, cycle, number)
        if status != RUNNING:
            return status


@compiled
def _change_task(spec, state, cycle, number):
    """Thread `number` finishes its task in `cycle` and takes the next one, idles or retires."""
    thread = state.core.threads[number]
    if thread["task"] != NO_TASK:
        thread["task"] = NO_TASK
        state.core.cores[thread["core"]]["tasks"] += 1
        state.run[0]["finished"] += 1
        state.run[0]["last_finish"] = cycle

    task = _task_for(state, thread)
    if task == NO_TASK:
        core_model.park(state.core, thread)
        if state.fifo.ends[1] < state.tasks.num_tasks:
            core_model.join_idle(state.core, number)
        return RUNNING

    position = task - state.tasks.first_task
    if position >= len(state.tasks.starts) - 1:
        return NEEDS_TASKS
    _take(spec, state, thread)
    thread["task"] = task
    core_model.read_record(thread, state.tasks.records, state.tasks.starts[position])
    return RUNNING


@compiled
def _task_for(state, thread):
    """The thread's next task, or NO_TASK if there is none to be had now."""
    task = thread["next_task"]
    if task == NO_TASK and fifo_model.num_queued(state.fifo) > 0:
        return state.fifo.ends[0]
    return task if task < state.tasks.num_tasks else NO_TASK


@compiled
def _take(spec, state, thread):
    """The thread takes the task that was found for it."""
    if spec.core.task_order == TaskOrder.INTERLEAVED:
        thread["next_task"] += len(state.core.threads)
    elif thread["next_task"] != NO_TASK:
        thread["next_task"] = NO_TASK
    else:
        state.fifo.ends[0] += 1


@inlined
def _operate(spec, state, cycle, number):
    """Issue the operation that closes the record of thread `number` in `cycle`."""
    thread = state.core.threads[number]
    cursor, op = thread["cursor"], thread["op"]
    address = state.tasks.records[cursor]["address"]
    core_model.read_record(thread, state.tasks.records, cursor + 1)
    if op == Op.LOAD or op == Op.STORE:
        core_model.park(state.core, thread)
        _access(
            spec, state, cycle, thread["core"], Request(address, WRITE if op == Op.STORE else READ, number)
        )
    elif op == Op.LOCK:
        if not locks_model.take(state.locks, cycle, address, number):
            thread["reason"] = STALL_LOCK
            core_model.park(state.core, thread)
    elif op == Op.UNLOCK:
        return _unlock(state, cycle, address, number)
    else:
        state.core.cores[thread["core"]]["emitted"] += 1
    return RUNNING


@compiled
def _unlock(state, cycle, lock, number):
    """Thread `number` releases the lock in `cycle`; the next in line goes on a cycle later."""
    heir = locks_model.release(state.locks, cycle, lock, number)
    if heir == NOT_HOLDER:
        state.run[0]["culprit"] = number
        return BAD_UNLOCK

    if heir != NOBODY:
        core_model.wake_at(state.core, cycle + 1, state.core.threads[heir])
    return RUNNING


@inlined
def _access(spec, state, cycle, core, request):
    """A core asks its cache. A cache that only this core talks to can look at once: nobody else comes in `cycle`."""
    cache = spec.core_cache[core]
    at_once = spec.is_private[cache] and fifo_model.num_items(state.cache.inbox, cache) == 0
    if not (at_once and _accept(spec, state, cycle, cache, request)):
        _put(spec, state, cycle, cache, core, request)


# ---- phase 2: lookups ----


@inlined
def _look_up_due(spec, state, cycle):
    """Every cache that has requests looks them up in `cycle`."""
    if state.run[0]["next_lookup"] <= cycle:
        _look_up_all(spec, state, cycle)


@compiled
def _look_up_all(spec, state, cycle):
    """Play the lookups of `cycle` and find out when the next one is."""
    next_lookup = NEVER
    for cache in range(len(spec.bursts)):
        if state.cache.caches[cache]["lookup_due"] <= cycle:
            _look_up(spec, state, cycle, cache)
    for cache in range(len(spec.bursts)):
        next_lookup = min(next_lookup, state.cache.caches[cache]["lookup_due"])
    state.run[0]["next_lookup"] = next_lookup


@compiled
def _look_up(spec, state, cycle, cache):
    """The cache accepts arrived requests in `cycle` while it has ports and nothing is refused."""
    inbox = state.cache.inbox
    for _ in range(spec.caches[cache]["num_ports"]):
        waiting = fifo_model.oldest(inbox, cache)
        if fifo_model.num_items(inbox, cache) == 0 or waiting["arrival"] > cycle:
            break
        request = Request(waiting["address"], waiting["kind"], waiting["requester"])
        if not _accept(spec, state, cycle, cache, request):
            state.cache.caches[cache]["blocked_since"] = cycle
            state.cache.caches[cache]["lookup_due"] = NEVER
            return
        fifo_model.remove(inbox, cache, 0)

    due = NEVER
    if fifo_model.num_items(inbox, cache) > 0:
        due = max(fifo_model.oldest(inbox, cache)["arrival"], cycle + 1)
    state.cache.caches[cache]["lookup_due"] = due


@inlined
def _accept(spec, state, cycle, cache, request):
    """Whether the cache accepts the request in `cycle`; sends what follows from it."""
    if cache_model.hits(spec.caches, state.cache, cache, request):
        if request.kind != WRITEBACK:
            _answer_hit(state, cycle + spec.caches[cache]["hit_cycles"], cache, request.requester)
        return True
    return _accept_absent(spec, state, cycle, cache, request)


@compiled
def _accept_absent(spec, state, cycle, cache, request):
    """The same for a line that is not present."""
    outcome = cache_model.accept_absent(spec.caches, state.cache, cycle, cache, request)
    if outcome == MISS:
        arrival = cycle + spec.caches[cache]["hit_cycles"]
        shift = spec.caches[cache]["line_shift"]
        mshr, victim = state.cache.caches[cache]["fetch"], state.cache.caches[cache]["victim"]
        if mshr != NO_MSHR:
            line = request.address >> shift
            _send(spec, state, arrival, cache, Request(line << shift, READ, _fetcher(cache, mshr)))
        if victim != NO_LINE:
            _send(spec, state, arrival, cache, Request(victim << shift, WRITEBACK, cache))
    return outcome != REFUSED


@inlined
def _answer_hit(state, arrival, cache, requester):
    """The requester of a hit gets its answer in cycle `arrival`."""
    if requester >= 0:
        thread = state.core.threads[requester]
        thread["reason"] = STALL_SUPPLIER + cache
        core_model.wake_at(state.core, arrival, thread)
    else:
        _answer_fetch(state, arrival, cache, requester)


@compiled
def _answer_fetch(state, arrival, sender, requester):
    """A fetch is answered by a cache or a channel in cycle `arrival`; a sender's answers come in order."""
    slot = fifo_model.insert(state.answers, sender, arrival, 0)
    state.answers.items[sender, slot]["requester"] = requester
    state.run[0]["next_answer"] = min(state.run[0]["next_answer"], arrival)


@compiled
def _send(spec, state, arrival, cache, request):
    """The cache sends a request that reaches its next level in cycle `arrival`."""
    parent = spec.caches[cache]["parent"]
    if parent != DRAM_PARENT:
        _put(spec, state, arrival, parent, spec.core.num_cores + cache, request)
        return

    arrival_ticks = arrival * spec.core.period_ticks
    queued = dram_model.send(spec.dram, state.dram, arrival_ticks, request.address, cache)
    queued["bursts"] = spec.bursts[cache]
    queued["is_write"] = request.kind == WRITEBACK
    queued["requester"] = request.requester
    channel = dram_model.field_of(request.address, spec.dram.channel)
    _watch_room(spec, state.dram.queue, channel, state.run)


@compiled
def _put(spec, state, arrival, cache, rank, request):
    """A request reaches the cache in cycle `arrival`; `rank` orders those of one cycle."""
    inbox = state.cache.inbox
    slot = fifo_model.insert(inbox, cache, arrival, rank)
    waiting = inbox.items[cache, slot]
    waiting["address"] = request.address
    waiting["kind"] = request.kind
    waiting["requester"] = request.requester
    if state.cache.caches[cache]["blocked_since"] == NOT_BLOCKED:
        state.cache.caches[cache]["lookup_due"] = min(state.cache.caches[cache]["lookup_due"], arrival)
        state.run[0]["next_lookup"] = min(state.run[0]["next_lookup"], arrival)
    _watch_room(spec, inbox, cache, state.run)


@compiled
def _watch_room(spec, queues, q, run):
    """Ask for larger queues when what one cycle may add would no longer fit."""
    if fifo_model.num_items(queues, q) + spec.spare_slots > queues.items.shape[1]:
        run[0]["needs_room"] = 1


@inlined
def _fetcher(cache, mshr):
    """Requester number of a cache's MSHR; threads have those from 0 up."""
    return ~(cache << 32 | mshr)


@inlined
def _mshr_of(requester):
    """Cache and MSHR of a requester number below 0."""
    return ~requester >> 32, ~requester & 0xFFFFFFFF


# ---- phase 3 and the next cycle ----


@inlined
def _next_cycle(spec, state, cycle):
    """The next cycle in which something can happen, or NEVER; the DRAM has played the memory clocks before it."""
    if core_model.any_ready(state.core, cycle + 1):
        limit = cycle + 1
    else:
        limit = _next_event(spec, state, cycle)
    if state.dram.next_due[0] * spec.dram.period_ticks < limit * spec.core.period_ticks:
        return _play_dram(spec, state, limit)
    return limit


@compiled
def _next_event(spec, state, cycle):
    """First cycle after `cycle` of which it is known already that something happens, or NEVER."""
    limit = min(min(state.run[0]["next_answer"], state.run[0]["next_lookup"]), _source_due(spec, state))
    num_slots = state.core.wake.shape[0]
    for later in range(cycle + 1, min(cycle + num_slots, limit)):
        if core_model.any_ready(state.core, later):
            return later
    return max(limit, cycle + 1)


@compiled
def _play_dram(spec, state, limit):
    """Play the memory clocks before cycle `limit`, or before the first answer if that is sooner; returns that cycle."""
    dram = state.dram
    core_period, period = spec.core.period_ticks, spec.dram.period_ticks
    while dram.next_due[0] * period < limit * core_period:
        if limit == NEVER and dram_model.is_empty(dram):
            return NEVER
        clock, channel = dram.next_due[0], dram_model.first_due(dram)
        requester = dram_model.wake(spec.dram, dram, clock, channel)
        state.run[0]["last_clock"] = clock
        if requester != NO_REQUESTER:
            half_ticks = dram_model.data_half_ticks(spec.dram, dram, channel)
            arrival = (half_ticks + 2 * core_period - 1) // (2 * core_period)
            _answer_fetch(state, arrival, len(spec.bursts) + channel, requester)
            limit = min(limit, arrival)
    return limit


@compiled
def _play_last_tick(spec, state):
    """The run ends with the tick in which the last thing on its way arrived: refreshes up to it count."""
    period = spec.dram.period_ticks
    last_tick = max(state.run[0]["cycle"] * spec.core.period_ticks, state.run[0]["last_clock"] * period)
    while state.dram.next_due[0] * period <= last_tick:
        dram_model.wake(spec.dram, state.dram, state.dram.next_due[0], dram_model.first_due(state.dram))
