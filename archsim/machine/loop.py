"""The main loop of the compiled machine: phases of one core cycle, and the jump to the next one that matters.

Time is counted in core cycles. The order of what meets in one cycle is README.md's: fills, source, issue, lookups;
then the DRAM plays the memory clocks that lie before the next cycle visited.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
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
    CacheTable,
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

ANSWER = np.dtype([(name, np.int64) for name in ("arrival", "rank", "requester")])


class Machine(NamedTuple):
    """MachineSpec as the loop wants it: plain integers and arrays of one type, so that one compilation serves all."""

    core: CoreSpec
    source: UnitSpec
    fifo: FifoSpec
    caches: CacheTable
    dram: DramSpec
    core_cache: np.ndarray  # [C] cache of the core
    is_private: np.ndarray  # [K] whether one core and nobody else talks to the cache
    bursts: np.ndarray  # [K] DRAM bursts of the cache's line
    spare_slots: int  # free slots that a queue needs at the beginning of a cycle


class RunState(NamedTuple):
    """Where the run stands; every field is [1], times in core cycles."""

    cycle: np.ndarray  # being played; the last one when the run is over
    next_core: np.ndarray  # first core that has not issued in it
    next_answer: np.ndarray  # when the first answer on its way arrives
    next_lookup: np.ndarray  # when the first cache has a request to look up
    finished: np.ndarray  # tasks
    last_finish: np.ndarray  # when the last of them was finished
    last_clock: np.ndarray  # last memory clock at which a channel was woken
    needs_room: np.ndarray  # whether a queue may overflow in the next cycle
    culprit: np.ndarray  # thread that unlocked what it did not hold


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
    run: RunState


@njit
def play(spec, state):
    """Play until the work is over or the caller must help; the status says which."""
    cycle = state.run.cycle[0]
    while cycle != NEVER:
        state.run.cycle[0] = cycle
        _fill_due(spec, state, cycle)
        core_model.wake_due(state.core, cycle)
        _make_task(spec, state, cycle)
        for core in range(state.run.next_core[0], spec.core.num_cores):
            status = _issue(spec, state, cycle, core)
            if status != RUNNING:
                state.run.next_core[0] = core
                return status
        state.run.next_core[0] = 0
        _look_up_due(spec, state, cycle)

        cycle = _next_cycle(spec, state, cycle)
        if state.run.needs_room[0] != 0 and cycle != NEVER:
            state.run.cycle[0] = cycle
            return NEEDS_ROOM
    _play_last_tick(spec, state)
    return OVER


# ---- phase 0: fills, then the source ----


@njit(forceinline=True)
def _fill_due(spec, state, cycle):
    """Deliver the answers that arrive in `cycle`."""
    if state.run.next_answer[0] <= cycle:
        _deliver(spec, state, cycle)


@njit
def _deliver(spec, state, cycle):
    """Hand the answers of `cycle` to those who fetched, and find out when the next one arrives."""
    answers = state.answers
    num_caches = len(spec.bursts)
    next_answer = NEVER
    for sender in range(len(answers.head)):
        while answers.count[sender] > 0:
            answer = answers.items[sender, answers.head[sender]]
            if answer["arrival"] > cycle:
                next_answer = min(next_answer, answer["arrival"])
                break
            state.filling[0] = answer["requester"]
            _fill_tree(spec, state, cycle, min(sender, num_caches))
            fifo_model.remove(answers, sender, 0)
    state.run.next_answer[0] = next_answer


@njit
def _fill_tree(spec, state, cycle, supplier):
    """Fill the line that `filling` begins with, in its cache and wherever it is waited for below, in `cycle`."""
    num_filling = 1
    while num_filling > 0:
        num_filling -= 1
        cache, mshr = _mshr_of(state.filling[num_filling])
        cache_model.fill(state.cache, cycle, cache, mshr)
        state.run.next_lookup[0] = min(state.run.next_lookup[0], state.cache.lookup_due[cache])
        for i in range(state.cache.num_waiting[cache, mshr]):
            requester = state.cache.targets[cache, mshr, i]
            if requester < 0:
                state.filling[num_filling] = requester
                num_filling += 1
            else:
                core = state.core.core_of[requester]
                state.core.reason[requester] = STALL_SUPPLIER + supplier
                core_model.wake_now(state.core, core, requester - core * spec.core.num_threads)


@njit(forceinline=True)
def _make_task(spec, state, cycle):
    """The source makes at most one task in `cycle`."""
    if _source_due(spec, state) <= cycle:
        _make_one(spec, state, cycle)


@njit(forceinline=True)
def _source_due(spec, state):
    """Cycle in which the source can make a task as things stand, or NEVER."""
    if state.fifo.ends[1] == state.tasks.num_tasks:
        return NEVER
    if core_model.num_idle(state.core) > 0 or fifo_model.has_room(spec.fifo, state.fifo):
        return state.source.ready[0]
    return NEVER


@njit
def _make_one(spec, state, cycle):
    """The source makes a task in `cycle`, for the longest idle thread or for the fifo."""
    task = state.fifo.ends[1]
    state.fifo.ends[1] = task + 1
    unit_model.start_interval(spec.source, state.source, cycle)
    if core_model.num_idle(state.core) > 0:
        state.fifo.ends[0] = task + 1
        core_model.hand_to_idle(spec.core, state.core, task)
    if task + 1 == state.tasks.num_tasks:
        core_model.retire_idle(state.core)


# ---- phase 1: issue ----


@njit(forceinline=True)
def _issue(spec, state, cycle, core):
    """The core issues at most one instruction in `cycle`."""
    cores = state.core
    while True:
        thread = core_model.pick(cores, core)
        if thread == NO_THREAD:
            return RUNNING
        number = core * spec.core.num_threads + thread
        if cores.compute_left[number] > 0:
            cores.compute_left[number] -= 1
            core_model.count_issue(spec.core, cores, cycle, core, thread)
            return RUNNING
        if cores.op[number] != Op.END:
            core_model.count_issue(spec.core, cores, cycle, core, thread)
            return _operate(spec, state, cycle, core, thread)
        status = _change_task(spec, state, cycle, core, thread)
        if status != RUNNING:
            return status


@njit
def _change_task(spec, state, cycle, core, thread):
    """The thread finishes its task in `cycle` and takes the next one, idles or retires."""
    cores = state.core
    number = core * spec.core.num_threads + thread
    if cores.task[number] != NO_TASK:
        cores.task[number] = NO_TASK
        cores.tasks[core] += 1
        state.run.finished[0] += 1
        state.run.last_finish[0] = cycle

    task = _task_for(spec, state, number)
    if task == NO_TASK:
        core_model.park(cores, core, thread)
        if state.fifo.ends[1] < state.tasks.num_tasks:
            core_model.join_idle(cores, number)
        return RUNNING

    position = task - state.tasks.first_task
    if position >= len(state.tasks.starts) - 1:
        return NEEDS_TASKS
    _take(spec, state, number)
    cores.task[number] = task
    core_model.read_record(cores, number, state.tasks.records, state.tasks.starts[position])
    return RUNNING


@njit
def _task_for(spec, state, number):
    """The next task of thread `number`, or NO_TASK if there is none to be had now."""
    task = state.core.next_task[number]
    if task == NO_TASK and fifo_model.num_queued(state.fifo) > 0:
        return state.fifo.ends[0]
    return task if task < state.tasks.num_tasks else NO_TASK


@njit
def _take(spec, state, number):
    """Thread `number` takes the task that was found for it."""
    if spec.core.task_order == TaskOrder.INTERLEAVED:
        state.core.next_task[number] += len(state.core.next_task)
    elif state.core.next_task[number] != NO_TASK:
        state.core.next_task[number] = NO_TASK
    else:
        state.fifo.ends[0] += 1


@njit(forceinline=True)
def _operate(spec, state, cycle, core, thread):
    """Issue the operation that closes the thread's record in `cycle`."""
    cores = state.core
    number = core * spec.core.num_threads + thread
    cursor = cores.cursor[number]
    address, op = state.tasks.records[cursor]["address"], cores.op[number]
    core_model.read_record(cores, number, state.tasks.records, cursor + 1)
    if op == Op.LOAD or op == Op.STORE:
        core_model.park(cores, core, thread)
        _access(spec, state, cycle, core, Request(address, WRITE if op == Op.STORE else READ, number))
    elif op == Op.LOCK:
        if not locks_model.take(state.locks, cycle, address, number):
            cores.reason[number] = STALL_LOCK
            core_model.park(cores, core, thread)
    elif op == Op.UNLOCK:
        return _unlock(spec, state, cycle, address, number)
    else:
        cores.emitted[core] += 1
    return RUNNING


@njit
def _unlock(spec, state, cycle, lock, number):
    """Thread `number` releases the lock in `cycle`; the next in line goes on a cycle later."""
    heir = locks_model.release(state.locks, cycle, lock, number)
    if heir == NOT_HOLDER:
        state.run.culprit[0] = number
        return BAD_UNLOCK

    if heir != NOBODY:
        core = state.core.core_of[heir]
        core_model.wake_at(state.core, cycle + 1, core, heir - core * spec.core.num_threads)
    return RUNNING


@njit(forceinline=True)
def _access(spec, state, cycle, core, request):
    """A core asks its cache. A cache that only this core talks to can look at once: nobody else comes in `cycle`."""
    cache = spec.core_cache[core]
    at_once = spec.is_private[cache] and state.cache.inbox.count[cache] == 0
    if not (at_once and _accept(spec, state, cycle, cache, request)):
        _put(spec, state, cycle, cache, core, request)


# ---- phase 2: lookups ----


@njit(forceinline=True)
def _look_up_due(spec, state, cycle):
    """Every cache that has requests looks them up in `cycle`."""
    if state.run.next_lookup[0] <= cycle:
        _look_up_all(spec, state, cycle)


@njit
def _look_up_all(spec, state, cycle):
    """Play the lookups of `cycle` and find out when the next one is."""
    next_lookup = NEVER
    for cache in range(len(spec.bursts)):
        if state.cache.lookup_due[cache] <= cycle:
            _look_up(spec, state, cycle, cache)
    for cache in range(len(spec.bursts)):
        next_lookup = min(next_lookup, state.cache.lookup_due[cache])
    state.run.next_lookup[0] = next_lookup


@njit
def _look_up(spec, state, cycle, cache):
    """The cache accepts arrived requests in `cycle` while it has ports and nothing is refused."""
    inbox = state.cache.inbox
    for _ in range(spec.caches.num_ports[cache]):
        waiting = inbox.items[cache, inbox.head[cache]]
        if inbox.count[cache] == 0 or waiting["arrival"] > cycle:
            break
        request = Request(waiting["address"], waiting["kind"], waiting["requester"])
        if not _accept(spec, state, cycle, cache, request):
            state.cache.blocked_since[cache] = cycle
            state.cache.lookup_due[cache] = NEVER
            return
        fifo_model.remove(inbox, cache, 0)

    due = NEVER
    if inbox.count[cache] > 0:
        due = max(inbox.items[cache, inbox.head[cache]]["arrival"], cycle + 1)
    state.cache.lookup_due[cache] = due


@njit(forceinline=True)
def _accept(spec, state, cycle, cache, request):
    """Whether the cache accepts the request in `cycle`; sends what follows from it."""
    if cache_model.hits(spec.caches, state.cache, cache, request):
        if request.kind != WRITEBACK:
            _answer_hit(spec, state, cycle + spec.caches.hit_cycles[cache], cache, request.requester)
        return True
    return _accept_absent(spec, state, cycle, cache, request)


@njit
def _accept_absent(spec, state, cycle, cache, request):
    """The same for a line that is not present."""
    outcome = cache_model.accept_absent(spec.caches, state.cache, cycle, cache, request)
    if outcome == MISS:
        arrival = cycle + spec.caches.hit_cycles[cache]
        shift = spec.caches.line_shift[cache]
        mshr, victim = state.cache.fetch[cache], state.cache.victim[cache]
        if mshr != NO_MSHR:
            way = state.cache.way_of[cache, mshr]
            fetch = Request(~state.cache.tags[way] << shift, READ, _fetcher(cache, mshr))
            _send(spec, state, arrival, cache, fetch)
        if victim != NO_LINE:
            _send(spec, state, arrival, cache, Request(victim << shift, WRITEBACK, cache))
    return outcome != REFUSED


@njit(forceinline=True)
def _answer_hit(spec, state, arrival, cache, requester):
    """The requester of a hit gets its answer in cycle `arrival`."""
    if requester >= 0:
        core = state.core.core_of[requester]
        state.core.reason[requester] = STALL_SUPPLIER + cache
        core_model.wake_at(state.core, arrival, core, requester - core * spec.core.num_threads)
    else:
        _answer_fetch(state, arrival, cache, requester)


@njit
def _answer_fetch(state, arrival, sender, requester):
    """A fetch is answered by a cache or a channel in cycle `arrival`; a sender's answers come in order."""
    slot = fifo_model.insert(state.answers, sender, arrival, 0)
    state.answers.items[sender, slot]["requester"] = requester
    state.run.next_answer[0] = min(state.run.next_answer[0], arrival)


@njit
def _send(spec, state, arrival, cache, request):
    """The cache sends a request that reaches its next level in cycle `arrival`."""
    parent = spec.caches.parent[cache]
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


@njit
def _put(spec, state, arrival, cache, rank, request):
    """A request reaches the cache in cycle `arrival`; `rank` orders those of one cycle."""
    inbox = state.cache.inbox
    slot = fifo_model.insert(inbox, cache, arrival, rank)
    waiting = inbox.items[cache, slot]
    waiting["address"] = request.address
    waiting["kind"] = request.kind
    waiting["requester"] = request.requester
    if state.cache.blocked_since[cache] == NOT_BLOCKED:
        state.cache.lookup_due[cache] = min(state.cache.lookup_due[cache], arrival)
        state.run.next_lookup[0] = min(state.run.next_lookup[0], arrival)
    _watch_room(spec, inbox, cache, state.run)


@njit
def _watch_room(spec, queues, q, run):
    """Ask for larger queues when what one cycle may add would no longer fit."""
    if queues.count[q] + spec.spare_slots > queues.items.shape[1]:
        run.needs_room[0] = 1


@njit(forceinline=True)
def _fetcher(cache, mshr):
    """Requester number of a cache's MSHR; threads have those from 0 up."""
    return ~(cache << 32 | mshr)


@njit(forceinline=True)
def _mshr_of(requester):
    """Cache and MSHR of a requester number below 0."""
    return ~requester >> 32, ~requester & 0xFFFFFFFF


# ---- phase 3 and the next cycle ----


@njit(forceinline=True)
def _next_cycle(spec, state, cycle):
    """The next cycle in which something can happen, or NEVER; the DRAM has played the memory clocks before it."""
    if core_model.any_ready(state.core, cycle + 1):
        limit = cycle + 1
    else:
        limit = _next_event(spec, state, cycle)
    if state.dram.next_due[0] * spec.dram.period_ticks < limit * spec.core.period_ticks:
        return _play_dram(spec, state, limit)
    return limit


@njit
def _next_event(spec, state, cycle):
    """First cycle after `cycle` of which it is known already that something happens, or NEVER."""
    limit = min(min(state.run.next_answer[0], state.run.next_lookup[0]), _source_due(spec, state))
    num_slots = state.core.wake.shape[0]
    for later in range(cycle + 1, min(cycle + num_slots, limit)):
        if core_model.any_ready(state.core, later):
            return later
    return max(limit, cycle + 1)


@njit
def _play_dram(spec, state, limit):
    """Play the memory clocks before cycle `limit`, or before the first answer if that is sooner; returns that cycle."""
    dram = state.dram
    core_period, period = spec.core.period_ticks, spec.dram.period_ticks
    while dram.next_due[0] * period < limit * core_period:
        if limit == NEVER and dram_model.is_empty(dram):
            return NEVER
        clock, channel = dram.next_due[0], dram_model.first_due(dram)
        requester = dram_model.wake(spec.dram, dram, clock, channel)
        state.run.last_clock[0] = clock
        if requester != NO_REQUESTER:
            half_ticks = dram_model.data_half_ticks(spec.dram, dram, channel)
            arrival = (half_ticks + 2 * core_period - 1) // (2 * core_period)
            _answer_fetch(state, arrival, len(spec.bursts) + channel, requester)
            limit = min(limit, arrival)
    return limit


@njit
def _play_last_tick(spec, state):
    """The run ends with the tick in which the last thing on its way arrived: refreshes up to it count."""
    period = spec.dram.period_ticks
    last_tick = max(state.run.cycle[0] * spec.core.period_ticks, state.run.last_clock[0] * period)
    while state.dram.next_due[0] * period <= last_tick:
        dram_model.wake(spec.dram, state.dram, state.dram.next_due[0], dram_model.first_due(state.dram))
