"""A multithreaded core, to be believed: a process that issues at most one instruction at every core edge."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Generator
from enum import Enum
from typing import Any, NamedTuple

import simpy

from archsim.model.cache.reference import Cache, Kind, Request
from archsim.model.core.spec import CoreSpec
from archsim.model.locks.reference import Locks
from archsim.model.reference import Phase, at, call
from archsim.model.waiting import Wait
from archsim.trace.records import Op

# Why a slot was empty; causes from 0 up (model/causes.py) are waits for memory.
NO_WORK = -2
LOCK = -1

_ACCESSES = {Op.LOAD: Kind.READ, Op.STORE: Kind.WRITE, Op.CLEAR: Kind.CLEAR}


class State(Enum):
    READY = "nothing"
    WAITING_MEMORY = "memory"
    WAITING_LOCK = "a lock"
    IDLE = "a task"
    RETIRED = "nothing, no task will come"


class Instruction(NamedTuple):
    """One issue slot. `op` None is a one-cycle instruction."""

    op: Op | None
    address: int = 0
    num_bytes: int = 0


def instructions(records: Any) -> deque[Instruction]:
    """A task's instructions one by one; END ends the task and is none of them."""
    listed: deque[Instruction] = deque()
    for record in records:
        listed.extend([Instruction(None)] * int(record["compute"]))
        if record["op"] == Op.END:
            break
        listed.append(Instruction(Op(int(record["op"])), int(record["address"]), int(record["bytes"])))
    return listed


class Thread:
    """A thread: its state, what is left of its task, and why it last waited."""

    def __init__(self, core: int, index: int, number: int):
        self.core, self.index, self.number = core, index, number
        self.state = State.READY
        self.ready_tick = 0
        self.has_task = False
        self.left: deque[Instruction] = deque()
        self.reason: int | Wait = NO_WORK  # why it last waited

    def __str__(self) -> str:
        return f"core {self.core} thread {self.index}"

    def is_ready(self, now: int) -> bool:
        return self.state is State.READY and now >= self.ready_tick

    def ready(self, tick: int) -> None:
        self.state, self.ready_tick = State.READY, tick

    def begin(self, task: Any) -> None:
        self.has_task, self.left = True, instructions(task)

    def hand(self, now: int, task: Any) -> None:
        """The source gives the idle thread a task: it is ready now."""
        self.begin(task)
        self.reason = NO_WORK
        self.ready(now)

    def wake(self, now: int) -> None:
        """The data is here: ready now."""
        self.ready(now)

    def cause_at(self, tick: int) -> int:
        """Why a slot at `tick` was empty that this thread could not use."""
        return self.reason.cause_at(tick) if isinstance(self.reason, Wait) else self.reason

    def idle(self) -> None:
        self.state = State.IDLE

    def retire(self) -> None:
        self.state = State.RETIRED


class Core:
    """One core: `num_threads` threads around one issue slot a cycle."""

    def __init__(
        self,
        spec: CoreSpec,
        env: simpy.Environment,
        index: int,
        cache: Cache,
        locks: Locks,
        take: Callable[[Thread], Any],
    ):
        self.spec, self.env, self.index = spec, env, index
        self.cache, self.locks = cache, locks
        self.take = take  # the next task of a thread, or None after it made the thread idle or retire
        first = index * spec.num_threads
        self.threads = [Thread(index, i, first + i) for i in range(spec.num_threads)]
        self.pointer = 0
        self.empty_slots: list[int] = []  # since the last issue

        self.useful = 0
        self.stalled: Counter[int] = Counter()  # empty slots by cause
        self.tasks = 0
        self.emitted = 0
        self.last_issue_tick = -spec.period_ticks
        self.last_finish_tick = 0

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: phase 1 of every core edge, until all threads have retired."""
        tick = 0
        while any(thread.state is not State.RETIRED for thread in self.threads):
            yield at(self.env, tick, Phase.ISSUE, self.index)
            thread = self._pick(tick)
            if thread is None:
                self.empty_slots.append(tick)
            else:
                self._issue(tick, thread)
            tick += self.spec.period_ticks

    def _pick(self, now: int) -> Thread | None:
        """The first ready thread at or after the pointer that has something to issue."""
        for step in range(len(self.threads)):
            thread = self.threads[(self.pointer + step) % len(self.threads)]
            while thread.is_ready(now) and not thread.left:
                self._next_task(now, thread)
            if thread.is_ready(now):
                return thread
        return None

    def _next_task(self, now: int, thread: Thread) -> None:
        if thread.has_task:
            thread.has_task = False
            self.tasks += 1
            self.last_finish_tick = now

        task = self.take(thread)
        if task is not None:
            thread.begin(task)

    def _issue(self, now: int, thread: Thread) -> None:
        self.useful += 1
        for tick in self.empty_slots:
            self.stalled[thread.cause_at(tick)] += 1
        self.empty_slots = []
        self.last_issue_tick = now
        self.pointer = (thread.index + 1) % len(self.threads)

        self._execute(now, thread, thread.left.popleft())

    def _execute(self, now: int, thread: Thread, instruction: Instruction) -> None:
        next_edge = now + self.spec.period_ticks
        if instruction.op in _ACCESSES:
            thread.state = State.WAITING_MEMORY
            self._access(now, thread, instruction)
        elif instruction.op == Op.LOCK:
            thread.ready(next_edge)
            if not self.locks.ask(now, thread, instruction.address):
                thread.state = State.WAITING_LOCK
                thread.reason = LOCK
        elif instruction.op == Op.UNLOCK:
            thread.ready(next_edge)
            granted = self.locks.release(now, thread, instruction.address)
            if granted is not None:
                granted.ready(next_edge)
        else:
            thread.ready(next_edge)
            self.emitted += instruction.op == Op.EMIT

    def _access(self, now: int, thread: Thread, instruction: Instruction) -> None:
        assert instruction.op is not None
        kind = _ACCESSES[instruction.op]
        thread.reason = Wait()
        request = Request(
            kind, instruction.address, instruction.num_bytes, thread.wake, thread.reason, self.index
        )
        call(at(self.env, now, Phase.ARRIVE, self.index), self.cache.arrive, request)
