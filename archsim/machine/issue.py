"""The cores' side of the compiled machine: the source makes tasks, threads take them and issue."""

from __future__ import annotations

import numpy as np

from archsim.machine import memory, waits
from archsim.machine.counters import STALL_LOCK
from archsim.machine.state import Machine, State
from archsim.machine.waits import IN_PARTS
from archsim.model.cache.compiled_state import CLEAR, READ, WRITE, Request
from archsim.model.compiled import NEVER, inlined_step, step
from archsim.model.core import compiled as core_model
from archsim.model.core import compiled_turns as turns
from archsim.model.core.compiled import NO_TASK, NO_THREAD
from archsim.model.core.spec import TaskOrder
from archsim.model.fifo import compiled as fifo_model
from archsim.model.locks import compiled as locks_model
from archsim.model.locks.compiled import NOBODY, NOT_HOLDER
from archsim.model.unit import compiled as unit_model
from archsim.trace.records import Op

PLAYED, NEEDS_TASKS, BAD_UNLOCK = range(3)  # what became of a core that was due
_NEEDS_TASKS_FIRST = -2  # in place of a thread's place


@inlined_step
def source_due(spec: Machine, state: State):
    """Cycle in which the source can make a task as things stand, or NEVER."""
    if state.fifo.ends[1] == state.tasks.num_tasks:
        return NEVER
    if core_model.num_idle(state.core) > 0 or fifo_model.has_room(spec.fifo, state.fifo):
        return state.source.ready[0]
    return NEVER


@step
def make_task(spec: Machine, state: State, cycle):
    """The source makes a task in `cycle`, for the longest idle thread or for the fifo."""
    task = state.fifo.ends[1]
    state.fifo.ends[1] = task + 1
    unit_model.start_interval(spec.source, state.source, cycle)
    if core_model.num_idle(state.core) > 0:
        state.fifo.ends[0] = task + 1
        turns.wake_now(state.core, cycle, core_model.hand_to_idle(state.core, task))
    if task + 1 == state.tasks.num_tasks:
        core_model.retire_idle(state.core)


@inlined_step
def issue(spec: Machine, state: State, cycle, core):
    """Let a core that is due in `cycle` catch up, wake threads, and do the operation whose turn it may be."""
    if turns.is_turn_of_first(state.core, core, cycle):
        place, turn = turns.issue_first(state.core, core, cycle)
    else:
        place, turn = _next_to_operate(spec, state, cycle, core)
        if place == _NEEDS_TASKS_FIRST:
            return NEEDS_TASKS
    if place != NO_THREAD:
        number = _number_of(state, core, place)
        turns.leave(state.core, core, number)
        if not _operate(spec, state, cycle, core, number, turn):
            return BAD_UNLOCK
    turns.plan(state.core, core)
    return PLAYED


@inlined_step
def _next_to_operate(spec, state, cycle, core):
    """Place and turn of the thread that does its operation in `cycle`, or NO_THREAD; threads wake and take tasks."""
    turns.play_to(state.core, core, cycle)
    turns.join_woken(state.core, cycle, core)
    place, turn = turns.next_in_turn(state.core, core)
    if place != NO_THREAD and _is_at_end(state, core, place, turn):
        place, turn = _pass_ends(spec, state, cycle, core, place, turn)
    if place < 0:
        return place, turn
    number = _number_of(state, core, place)
    _charge_empty_slots(spec, state, cycle, core, number)
    if not turns.does_operation(state.core, number, turn):
        return NO_THREAD, turn
    turns.use_slot(state.core, cycle, core, place, turn)
    return place, turn


@inlined_step
def _number_of(state, core, place):
    """Number of the core's thread at this place among all cores'."""
    return np.uint32(state.core.cores[core]["first_thread"] + place)


@inlined_step
def _is_at_end(state, core, place, turn):
    """Whether the thread has come to the end of its task."""
    number = _number_of(state, core, place)
    return state.core.threads[number]["op"] == Op.END and turns.does_operation(state.core, number, turn)


@step
def _pass_ends(spec, state, cycle, core, place, turn):
    """Threads at the end of their tasks, that at `place` first, take others until one can issue; it and its turn."""
    while place != NO_THREAD and _is_at_end(state, core, place, turn):
        number = _number_of(state, core, place)
        turns.leave(state.core, core, number)
        if not _change_task(spec, state, cycle, number, turn):
            turns.come_back(state.core, core, number)
            return _NEEDS_TASKS_FIRST, turn
        place, turn = turns.next_in_turn(state.core, core)
    return place, turn


@inlined_step
def _charge_empty_slots(spec, state, cycle, core, number):
    """The core's slots before `cycle` that were not played were empty for what thread `number` waited for."""
    owner, reason = state.core.cores[core], state.core.threads[number]["reason"]
    first = owner["next_slot"]
    if cycle > first:
        counts = state.core.stalled[core]
        if reason == IN_PARTS:
            waits.charge(spec, state, counts, (first, cycle), (number, spec.core_cache[core]))
        else:
            counts[reason] += cycle - first
        owner["next_slot"] = cycle


@step
def _change_task(spec, state, cycle, number, turn):
    """Thread `number` finishes its task in `cycle` and takes the next one, idles or retires; False if none is here."""
    thread, run = state.core.threads[number], state.run[0]
    if thread["task"] != NO_TASK:
        thread["task"] = NO_TASK
        state.core.cores[thread["core"]]["tasks"] += 1
        run["finished"] += 1
        run["last_finish"] = cycle

    task = _task_for(state, thread)
    if state.fifo.ends[1] < state.tasks.num_tasks:
        run["horizon"] = cycle  # the source may go on
    if task == NO_TASK:
        thread["compute"] = 0  # of the record that it has done
        turns.park(state.core, number)
        if state.fifo.ends[1] < state.tasks.num_tasks:
            core_model.join_idle(state.core, number)
        return True

    position = task - state.tasks.first_task
    if position >= len(state.tasks.starts) - 1:
        return False
    _take(spec, state, thread)
    thread["task"] = task
    core_model.read_record(state.core, thread, state.tasks.records, state.tasks.starts[position])
    turns.go_on(state.core, number, turn)
    return True


@step
def _task_for(state, thread):
    """The thread's next task, or NO_TASK if there is none to be had now."""
    task = thread["next_task"]
    if task == NO_TASK and fifo_model.num_queued(state.fifo) > 0:
        return state.fifo.ends[0]
    return task if task < state.tasks.num_tasks else NO_TASK


@step
def _take(spec, state, thread):
    """The thread takes the task that was found for it."""
    if spec.core.task_order == TaskOrder.INTERLEAVED:
        thread["next_task"] += len(state.core.threads)
    elif thread["next_task"] != NO_TASK:
        thread["next_task"] = NO_TASK
    else:
        state.fifo.ends[0] += 1


@inlined_step
def _operate(spec, state, cycle, core, number, turn):
    """Issue the operation that closes the record of thread `number` in `cycle`; False if it may not be done."""
    thread = state.core.threads[number]
    cursor, op = thread["cursor"], thread["op"]
    address, num_bytes = state.tasks.records[cursor]["address"], state.tasks.records[cursor]["bytes"]
    core_model.read_record(state.core, thread, state.tasks.records, cursor + 1)
    if op == Op.LOAD or op == Op.STORE or op == Op.CLEAR:
        turns.park(state.core, number)
        kind = READ if op == Op.LOAD else WRITE if op == Op.STORE else CLEAR
        memory.access(spec, state, cycle, core, Request(address, num_bytes, kind, number))
        return True
    if op == Op.LOCK and not locks_model.take(state.locks, cycle, address, number):
        thread["reason"] = STALL_LOCK
        turns.park(state.core, number)
        return True
    turns.go_on(state.core, number, turn + 1)
    return op != Op.UNLOCK or _unlock(state, cycle, address, number)


@step
def _unlock(state, cycle, lock, number):
    """Thread `number` releases the lock in `cycle`; the next in line goes on a cycle later. False if it has it not."""
    heir = locks_model.release(state.locks, cycle, lock, number)
    if heir == NOT_HOLDER:
        state.run[0]["culprit"] = number
        return False

    if heir != NOBODY:
        turns.wake_at(state.core, cycle + 1, heir)
    return True
