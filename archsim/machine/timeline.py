"""What every part of a machine did when: recorded from the reference model, whose cycles are also the compiled one's.

The recorder puts itself between the parts of one machine before it runs; a machine without one pays nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from archsim.machine.counters import Counters
from archsim.machine.reference import Machine, simulate
from archsim.machine.spec import MachineSpec
from archsim.model.cache.reference import Cache, Request
from archsim.model.causes import level_of
from archsim.model.core.reference import LOCK, NO_WORK, Core, Thread
from archsim.model.dram.commands import Command
from archsim.model.waiting import Wait
from archsim.trace.stream import Work


class Slot(NamedTuple):
    """One issue slot that was used."""

    tick: int
    core: int
    thread: int
    op: str  # COMPUTE, or the name of an Op


class Span(NamedTuple):
    """Something that lasted."""

    start: int  # tick
    end: int
    name: str


class Access(NamedTuple):
    """A request to a cache, from its arrival to its answer."""

    start: int  # tick
    end: int
    cache: int
    kind: str
    address: int
    supplier: int  # level whose data it was: a cache's index, or the number of caches for the DRAM


class DramCommand(NamedTuple):
    """A command of a channel."""

    tick: int
    channel: int
    command: str
    bank: int
    row: int
    clocks: int  # memory clocks for which a data bus is busy with it, or 1


class Timeline(NamedTuple):
    """Everything that was recorded, in the order in which it happened."""

    spec: MachineSpec
    counters: Counters
    slots: list[Slot]
    waits: dict[tuple[int, int], list[Span]]  # (core, thread) -> what it waited for
    tasks: dict[tuple[int, int], list[Span]]  # (core, thread) -> its tasks
    accesses: list[Access]
    commands: list[DramCommand]
    queues: list[tuple[int, int, int]]  # (tick, channel, requests waiting), at every change


COMPUTE = "COMPUTE"


def record(spec: MachineSpec, work: Work) -> Timeline:
    """Play work on the reference model and return what happened. All of it is kept: meant for a few hundred tasks."""
    recorder = _Recorder(spec)
    counters = simulate(spec, work, observe=recorder.attach)
    return recorder.timeline(counters)


def _between(part: Any, name: str, wrap: Callable[[Any], Any]) -> None:
    """Put what `wrap` makes of a part's method in its place, for this part only."""
    setattr(part, name, wrap(getattr(part, name)))


class _Recorder:
    """Notes what the parts of one machine do."""

    def __init__(self, spec: MachineSpec):
        self.spec = spec
        self.period = spec.core.period_ticks
        self.slots: list[Slot] = []
        self.waits: dict[tuple[int, int], list[Span]] = {}
        self.tasks: dict[tuple[int, int], list[Span]] = {}
        self.accesses: list[Access] = []
        self.commands: list[DramCommand] = []
        self.queues: list[tuple[int, int, int]] = []
        self.begun: dict[tuple[int, int], int] = {}  # tick of a thread's task under way
        self.free: dict[tuple[int, int], int] = {}  # first edge after a thread's latest slot
        self.numbers: Counter[tuple[int, int]] = Counter()  # tasks of each thread

    def attach(self, machine: Machine) -> None:
        for core in machine.cores:
            _between(core, "_issue", partial(self._issue, core))
            _between(core, "_next_task", self._next_task)
            for thread in core.threads:
                own = (thread.core, thread.index)
                self.waits[own], self.tasks[own], self.free[own] = [], [], 0
        for cache in machine.caches:
            _between(cache, "arrive", partial(self._arrive, cache))
        for channel in machine.dram.channels:
            channel.record = self._command
            _between(channel, "arrive", partial(self._queue, channel))

    def timeline(self, counters: Counters) -> Timeline:
        return Timeline(
            self.spec, counters, self.slots, self.waits, self.tasks, self.accesses, self.commands, self.queues
        )

    def _issue(self, core: Core, issue: Callable[[int, Thread], None]) -> Callable[[int, Thread], None]:
        def noted(now: int, thread: Thread) -> None:
            own = (thread.core, thread.index)
            if thread.ready_tick > self.free[own]:
                self.waits[own].append(Span(self.free[own], thread.ready_tick, self._reason(thread)))
            op = thread.left[0].op
            self.slots.append(Slot(now, core.index, thread.index, COMPUTE if op is None else op.name))
            self.free[own] = now + self.period
            issue(now, thread)

        return noted

    def _next_task(self, next_task: Callable[[int, Thread], None]) -> Callable[[int, Thread], None]:
        def noted(now: int, thread: Thread) -> None:
            own = (thread.core, thread.index)
            if thread.has_task and own in self.begun:
                self.tasks[own].append(Span(self.begun.pop(own), now, f"task {self.numbers[own]}"))
                self.numbers[own] += 1
            next_task(now, thread)
            if thread.has_task:
                self.begun[own] = now

        return noted

    def _arrive(self, cache: Cache, arrive: Callable[[Request], None]) -> Callable[[Request], None]:
        def noted(request: Request) -> None:
            answer, start = request.answer, int(cache.env.now)
            if answer is None:
                arrive(request)
                return

            def answered(tick: int) -> None:
                kind, address, level = request.kind.value, request.address, self._level(request.wait, tick)
                self.accesses.append(Access(start, tick, cache.index, kind, address, level))
                answer(tick)

            arrive(request._replace(answer=answered))

        return noted

    def _command(
        self, clock: int, channel: int, command: Any, bank: int, row: int, column: int, bursts: int
    ) -> None:
        clocks = max(1, bursts * self.spec.dram.burst_clocks)
        tick = clock * self.spec.dram.period_ticks
        self.commands.append(DramCommand(tick, channel, Command(command).name, bank, row, clocks))

    def _queue(self, channel: Any, arrive: Callable[[Request], None]) -> Callable[[Request], None]:
        def noted(request: Request) -> None:
            arrive(request)
            waiting = len(channel.reads) + (len(channel.writes) if channel.writes is not channel.reads else 0)
            self.queues.append((int(channel.env.now), channel.index, waiting))

        return noted

    def _level(self, wait: Wait, tick: int) -> int:
        """The level that supplied the data that came at `tick`: where the request was last."""
        return level_of(wait.cause_at(tick), len(self.spec.caches))

    def _reason(self, thread: Thread) -> str:
        if not isinstance(thread.reason, Wait):
            return {NO_WORK: "no work", LOCK: "lock"}[thread.reason]
        level = self._level(thread.reason, thread.ready_tick)
        return "dram" if level == len(self.spec.caches) else f"cache {level}"
