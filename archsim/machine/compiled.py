"""The machine, compiled: plays work on a spec and returns exactly the counters of reference.py, much faster."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from archsim.errors import ArchsimError, DeadlockError, Problem, fail
from archsim.machine.counters import STALL_MEMORY, STALL_NO_WORK, Counters
from archsim.machine.flush import drained_cycles, flushed, next_dirty
from archsim.machine.loading import load_next, nothing_loaded
from archsim.machine.loop import BAD_UNLOCK, NEEDS_ROOM, NEEDS_TASKS, PAUSED, play
from archsim.machine.series import Sampling, sample_of
from archsim.machine.spec import MachineSpec
from archsim.machine.state import ANSWER, RUN, Machine, State
from archsim.machine.waits import all_latencies, new_waits
from archsim.machine.watch import Levels, Watch
from archsim.machine.watching import Teller
from archsim.model.cache.compiled_state import (
    CACHE_COUNTS,
    HIT,
    MERGE,
    MISS,
    NOT_BLOCKED,
    READ,
    WRITE,
    WRITEBACK,
    cache_table,
    least_bursts,
    most_fetches,
    most_sent,
    new_caches,
)
from archsim.model.cache.spec import DRAM_PARENT, CacheSpec
from archsim.model.causes import num_causes
from archsim.model.compiled import NEVER, QueueState, grown, integers, new_queues
from archsim.model.core.compiled import NO_TASK, new_cores
from archsim.model.core.spec import TaskOrder
from archsim.model.dram.commands import DRAM_COUNTERS, CommandSink
from archsim.model.dram.compiled import new_dram
from archsim.model.dram.spec import DramSpec
from archsim.model.fifo.compiled import new_fifo
from archsim.model.locks.compiled import new_locks
from archsim.model.unit.compiled import new_source
from archsim.trace.records import Op
from archsim.trace.stream import Work

Progress = Callable[[int, int], Any]  # called with the tasks finished and all tasks


def simulate(
    spec: MachineSpec,
    work: Work,
    progress: Progress | None = None,
    sink: CommandSink | None = None,
    watch: Watch | None = None,
    flush: bool = False,
    sampling: Sampling | None = None,
) -> Counters:
    """Play the work to its end and to the last request's; the DRAM's commands go to `sink`.

    With `flush` all dirty lines are written back at the end. `sampling` is told counts at intervals. Raises
    ArchsimError for work that cannot be played.
    """
    machine = _machine(spec)
    levels = Levels(len(spec.caches), spec.core.period_ticks, spec.dram.period_ticks)
    teller = Teller(levels, sink, watch)
    state = teller.ready(_initial_state(spec, machine, work.num_tasks, () if watch is None else watch.places))
    if sampling is not None:
        state.run[0]["pause"] = sampling.interval_cycles
    if work.num_tasks == 0:
        return _counters(spec, machine, state)

    def with_room(state: State) -> State:
        teller.collect(state, is_over=False)
        return _with_room(machine, state)

    unflushed = list(range(len(spec.caches))) if flush else []
    while True:
        status = play(machine, state)
        if status == NEEDS_TASKS:
            if progress is not None:
                progress(int(state.run[0]["finished"]), work.num_tasks)
            state = _with_next_chunk(spec, state, work)
        elif status == NEEDS_ROOM:
            state = with_room(state)
        elif status == PAUSED:
            assert sampling is not None
            sampling.take(sample_of(int(state.run[0]["pause"]), _counters(spec, machine, state)))
            state.run[0]["pause"] += sampling.interval_cycles
        elif status == BAD_UNLOCK:
            raise _bad_unlock(state)
        elif state.run[0]["finished"] < work.num_tasks or np.any(state.cache.inbox.ends["count"]):
            raise _deadlock(spec, state)
        elif (cache := next_dirty(machine, state, unflushed)) is not None:
            state = flushed(machine, state, cache, with_room)
        else:
            break

    teller.collect(state, is_over=True)
    if progress is not None:
        progress(work.num_tasks, work.num_tasks)
    return _counters(spec, machine, state)


def _machine(spec: MachineSpec) -> Machine:
    """The spec as the loop wants it. ArchsimError where it makes no sense."""
    beats_bytes = spec.dram.burst_beats * spec.dram.beat_bytes
    users = [sum(user == cache for user in spec.core_cache) for cache in range(len(spec.caches))]
    parents = [cache.parent for cache in spec.caches]
    check_memory(spec.caches, spec.dram)
    return Machine(
        core=integers(spec.core),
        source=integers(spec.source),
        fifo=integers(spec.fifo),
        caches=cache_table(spec.caches, beats_bytes),
        dram=integers(spec.dram),
        core_cache=np.array(spec.core_cache, np.int64),
        is_private=np.array([n == 1 and cache not in parents for cache, n in enumerate(users)], np.bool_),
        spare_slots=spec.core.num_cores + most_sent(spec.caches),
        answer_clocks=spec.dram.read_clocks(least_bursts(spec.caches, beats_bytes)),
    )


def check_memory(caches: tuple[CacheSpec, ...], dram: DramSpec) -> None:
    """ArchsimError for addresses that would lead outside a table."""
    for number, cache in enumerate(caches):
        if cache.parent == DRAM_PARENT:
            continue
        if not number < cache.parent < len(caches):
            raise fail(f"cache {number}: its parent {cache.parent} is not a cache behind it")
    burst_bytes = dram.burst_beats * dram.beat_bytes
    if burst_bytes & (burst_bytes - 1) != 0:
        raise fail(f"dram: its bursts of {burst_bytes} bytes are not a power of two")
    if 1 << dram.channel.bits > dram.num_channels:
        raise fail("dram: the channel field addresses more channels than there are")
    if 1 << dram.bank.bits > dram.num_banks:
        raise fail("dram: the bank field addresses more banks than there are")


def _initial_state(spec: MachineSpec, machine: Machine, num_tasks: int, watched: tuple[int, ...]) -> State:
    """Tick 0: all threads ready without a task, caches and queues empty, no task loaded."""
    num_caches = len(spec.caches)
    num_threads = spec.core.num_cores * spec.core.num_threads
    num_fetches = most_fetches(spec.caches) + 1
    longest_wake = max((cache.hit_cycles for cache in spec.caches), default=1)
    queue_capacity = 64 + 2 * machine.spare_slots

    fifo = new_fifo()
    is_ideal = spec.source.interval_cycles == 0
    if spec.core.task_order == TaskOrder.INTERLEAVED:
        fifo.ends[:] = num_tasks
    elif is_ideal:
        fifo.ends[1] = num_tasks
    run = np.zeros(1, RUN)
    run["next_answer"] = run["next_lookup"] = run["pause"] = NEVER
    cache = new_caches(machine.caches, spec.caches, queue_capacity, watched)
    return State(
        core=new_cores(machine.core, STALL_MEMORY + num_causes(num_caches), longest_wake),
        locks=new_locks(spec.locks, num_threads),
        source=new_source(),
        fifo=fifo,
        cache=cache,
        dram=new_dram(machine.dram, queue_capacity),
        answers=new_queues(2, num_fetches, ANSWER),
        filling=np.zeros(num_fetches, np.int64),
        sources=np.zeros(num_fetches, np.int64),
        waits=new_waits(num_threads, cache.mshrs, are_threads_at_dram=False),
        tasks=nothing_loaded(num_tasks),
        run=run,
    )


def _with_next_chunk(spec: MachineSpec, state: State, work: Work) -> State:
    """The state with one more chunk and without the tasks that no thread needs any more."""
    threads = state.core.threads
    wanted = np.concatenate([threads["task"], threads["next_task"]])
    if spec.core.task_order == TaskOrder.FIRST_FREE:
        wanted = np.append(wanted, state.fifo.ends[0])
    loaded = state.tasks
    end = loaded.first_task + len(loaded.starts) - 1
    first_needed = min(int(wanted[wanted != NO_TASK].min()), end)

    threads["cursor"] -= np.uint32(loaded.starts[first_needed - loaded.first_task])
    return state._replace(tasks=load_next(spec, loaded, work.chunks, first_needed))


def _with_room(machine: Machine, state: State) -> State:
    """The state with larger queues, where what a cycle may add no longer fits in."""
    state.run[0]["needs_room"] = 0
    cache = state.cache._replace(inbox=roomy(state.cache.inbox, machine.spare_slots))
    dram = state.dram._replace(queue=roomy(state.dram.queue, machine.spare_slots))
    return state._replace(cache=cache, dram=dram)


def roomy(queues: QueueState, spare_slots: int) -> QueueState:
    """The queues, larger if one of them has fewer free slots than that."""
    is_crowded = np.any(queues.ends["count"] + np.int64(spare_slots) > queues.items.shape[1])
    return grown(queues) if is_crowded else queues


def _bad_unlock(state: State) -> ArchsimError:
    """A thread released a lock that it did not hold."""
    number = state.run[0]["culprit"]
    lock = _last_operation(state, number)["address"]
    return fail(f"thread {number} unlocks lock {lock}, which it does not hold")


def _deadlock(spec: MachineSpec, state: State) -> DeadlockError:
    """What every unfinished thread waits for."""
    what = [
        _waits_for(spec, state, int(number))
        for number in np.flatnonzero(state.core.threads["task"] != NO_TASK)
    ]
    cycle = int(state.run[0]["cycle"])
    head = f"deadlock in core cycle {cycle}: {state.run[0]['finished']} of {state.tasks.num_tasks} tasks finished"
    return DeadlockError([Problem(None, head), *[Problem(None, line) for line in what]])


def _waits_for(spec: MachineSpec, state: State, number: int) -> str:
    """One line on a thread that waits."""
    core, thread = divmod(number, spec.core.num_threads)
    record = _last_operation(state, number)
    operation, address = Op(record["op"]), record["address"]
    if operation != Op.LOCK:
        return f"core {core} thread {thread} waits for its {operation.name} of address {address}"
    holder_core, holder = divmod(int(state.locks.locks[address]["holder"]), spec.core.num_threads)
    return f"core {core} thread {thread} waits for lock {address}, held by core {holder_core} thread {holder}"


def _last_operation(state: State, number: int) -> Any:
    """The record whose operation the thread issued last. EMITs behind it are part of what it goes on with."""
    records, position = state.tasks.records, int(state.core.threads[number]["cursor"]) - 1
    while records[position]["op"] == Op.EMIT:
        position -= 1
    return records[position]


def _counters(spec: MachineSpec, machine: Machine, state: State) -> Counters:
    """What the state says at the end of a run."""
    cores, locks = state.core.cores, state.locks.counts[0]
    run, period = state.run[0], spec.core.period_ticks
    stalled = state.core.stalled.copy()
    stalled[:, STALL_NO_WORK] += run["last_finish"] - cores["next_slot"]
    return Counters(
        cycles=int(run["last_finish"]),
        stalled=stalled,
        **{name: cores[name].copy() for name in ("useful", "tasks", "emitted")},
        locks_taken=int(locks["taken"]),
        locks_waited=int(locks["waited"]),
        lock_wait_ticks=int(locks["wait_cycles"]) * period,
        drained_cycles=drained_cycles(state.run, period, spec.dram.period_ticks),
        **memory_counters(state, machine.caches["hit_cycles"], period),
    )


def memory_counters(state: Any, hit_cycles: np.ndarray, period_ticks: int) -> dict[str, np.ndarray]:
    """The counters of caches and DRAM by name, at the end of a run, of cores or of stages. `hit_cycles`: [K]."""
    cache, last_cycle = state.cache, state.run[0]["cycle"]
    caches, channels = cache.caches, state.dram.channels
    is_blocked = caches["blocked_since"] != NOT_BLOCKED
    by_kind, by_outcome = cache.accepted.sum(axis=2), cache.accepted.sum(axis=1)
    answered = by_kind[:, READ] + by_kind[:, WRITE] + caches["clears"]
    return {
        "latencies": all_latencies(state.waits, hit_cycles, answered),
        "cache_reads": by_kind[:, READ].copy(),
        "cache_writes": by_kind[:, WRITE].copy(),
        "cache_writebacks_in": by_kind[:, WRITEBACK].copy(),
        "cache_hits": by_outcome[:, HIT].copy(),
        "cache_merges": by_outcome[:, MERGE].copy(),
        "cache_misses": by_outcome[:, MISS].copy(),
        **{f"cache_{name}": caches[name].copy() for name in CACHE_COUNTS},
        "cache_blocked": caches["blocked"] + np.where(is_blocked, last_cycle - caches["blocked_since"], 0),
        "cache_fetch_ticks": caches["fetch_cycles"] * period_ticks,
        **{f"dram_{name}": channels[name].copy() for name in DRAM_COUNTERS},
    }
