"""What every part of a machine did when: recorded from the reference model, whose cycles are also the compiled one's.

The recorder puts itself between the parts of one machine before it runs; a machine without one pays nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from archsim.machine.reference import Machine, simulate
from archsim.machine.spec import MachineSpec
from archsim.model.cache.reference import Cache, Request
from archsim.model.causes import level_of
from archsim.model.core.reference import LOCK, NO_WORK, Core, Thread
from archsim.model.dram.commands import Command
from archsim.model.dram.spec import DramSpec
from archsim.model.fifo.reference import Fifo
from archsim.model.reference import stop_at
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


Place = tuple[int, int]  # (core, thread), or (unit, 0) in a pipeline


class Timeline(NamedTuple):
    """Everything that was recorded, in the order in which it happened."""

    period_ticks: int  # of a cycle
    dram_period_ticks: int
    slots: list[Slot]
    waits: dict[Place, list[Span]]  # what threads waited for, or what units did
    tasks: dict[Place, list[Span]]
    accesses: list[Access]
    commands: list[DramCommand]
    queues: list[tuple[int, int, int]]  # (tick, channel, requests waiting), at every change
    held: list[tuple[int, int, int]]  # (tick, fifo or delay stream, items or bytes in it), at every change


class Window(NamedTuple):
    """Cycles that are recorded."""

    first: int
    last: int  # the first one that is not


NEVER = 1 << 62
ALL = Window(0, NEVER)
COMPUTE = "COMPUTE"
_LATER = 500  # cycles that are played behind a window, in which most of what began within ends


def record(spec: MachineSpec, work: Work, window: Window = ALL) -> Timeline:
    """Play work on the reference model and return what happened in a window of core cycles; it ends behind that."""
    recorder = Recorder(spec, window)
    simulate(spec, work, observe=recorder.attach)
    return recorder.timeline()


def between(part: Any, name: str, wrap: Callable[[Any], Any]) -> None:
    """Put what `wrap` makes of a part's method in its place, for this part only."""
    setattr(part, name, wrap(getattr(part, name)))


class MemoryRecorder:
    """Notes what the caches and the DRAM of one machine do in a window of its cycles."""

    def __init__(self, period_ticks: int, num_caches: int, dram: DramSpec, window: Window):
        self.period, self.num_caches, self.dram = period_ticks, num_caches, dram
        self.first, self.last = window.first * period_ticks, min(window.last * period_ticks, NEVER)  # ticks
        self.accesses: list[Access] = []
        self.commands: list[DramCommand] = []
        self.queues: list[tuple[int, int, int]] = []

    def attach_memory(self, machine: Any) -> None:
        if self.last < NEVER:
            self.stop_behind(machine.env)
        for cache in machine.caches:
            between(cache, "arrive", partial(self._arrive, cache))
        for channel in machine.dram.channels:
            channel.record = self._command
            between(channel, "arrive", partial(self._queue, channel))

    def stop_behind(self, env: Any) -> None:
        """End the run when most of what began within the window has ended."""
        stop_at(env, self.last + _LATER * self.period)

    def shows(self, start: int, end: int) -> bool:
        """Whether something that lasted from tick to tick is within the window."""
        return end >= self.first and start < self.last

    def _arrive(self, cache: Cache, arrive: Callable[[Request], None]) -> Callable[[Request], None]:
        def noted(request: Request) -> None:
            answer, start = request.answer, int(cache.env.now)
            if answer is None:
                arrive(request)
                return

            def answered(tick: int) -> None:
                kind, address, level = request.kind.value, request.address, self.level(request.wait, tick)
                if self.shows(start, tick):
                    self.accesses.append(Access(start, tick, cache.index, kind, address, level))
                answer(tick)

            arrive(request._replace(answer=answered))

        return noted

    def _command(
        self, clock: int, channel: int, command: Any, bank: int, row: int, column: int, bursts: int
    ) -> None:
        clocks = max(1, bursts * self.dram.burst_clocks)
        tick = clock * self.dram.period_ticks
        if self.shows(tick, tick):
            self.commands.append(DramCommand(tick, channel, Command(command).name, bank, row, clocks))

    def _queue(self, channel: Any, arrive: Callable[[Request], None]) -> Callable[[Request], None]:
        def noted(request: Request) -> None:
            arrive(request)
            waiting = len(channel.reads) + (len(channel.writes) if channel.writes is not channel.reads else 0)
            if self.shows(int(channel.env.now), int(channel.env.now)):
                self.queues.append((int(channel.env.now), channel.index, waiting))

        return noted

    def level(self, wait: Wait, tick: int) -> int:
        """The level that supplied the data that came at `tick`: where the request was last."""
        return level_of(wait.cause_at(tick), self.num_caches)


class Recorder(MemoryRecorder):
    """Notes what the cores do besides."""

    def __init__(self, spec: MachineSpec, window: Window = ALL):
        super().__init__(spec.core.period_ticks, len(spec.caches), spec.dram, window)
        self.slots: list[Slot] = []
        self.waits: dict[Place, list[Span]] = {}
        self.tasks: dict[Place, list[Span]] = {}
        self.held: list[tuple[int, int, int]] = []
        self.begun: dict[Place, int] = {}  # tick of a thread's task under way
        self.free: dict[Place, int] = {}  # first edge after a thread's latest slot
        self.numbers: Counter[Place] = Counter()  # tasks of each thread

    def attach(self, machine: Machine) -> None:
        """Begin to note."""
        for core in machine.cores:
            between(core, "_issue", partial(self._issue, core))
            between(core, "_next_task", self._next_task)
            for thread in core.threads:
                own = (thread.core, thread.index)
                self.waits[own], self.tasks[own], self.free[own] = [], [], 0
        if machine.source is not None:
            fifo = machine.source.fifo
            for change in ("push", "pop"):
                between(fifo, change, partial(self._change, fifo, machine.env))
        self.attach_memory(machine)

    def timeline(self) -> Timeline:
        """What was noted."""
        return Timeline(
            self.period,
            self.dram.period_ticks,
            self.slots,
            self.waits,
            self.tasks,
            self.accesses,
            self.commands,
            self.queues,
            self.held,
        )

    def _change(self, fifo: Fifo, env: Any, change: Callable[..., Any]) -> Callable[..., Any]:
        def noted(*item: Any) -> Any:
            changed = change(*item)
            if self.shows(int(env.now), int(env.now)):
                self.held.append((int(env.now), 0, len(fifo.items)))
            return changed

        return noted

    def _issue(self, core: Core, issue: Callable[[int, Thread], None]) -> Callable[[int, Thread], None]:
        def noted(now: int, thread: Thread) -> None:
            own = (thread.core, thread.index)
            if thread.ready_tick > self.free[own] and self.shows(self.free[own], thread.ready_tick):
                self.waits[own].append(Span(self.free[own], thread.ready_tick, self._reason(thread)))
            op = thread.left[0].op
            if self.shows(now, now):
                self.slots.append(Slot(now, core.index, thread.index, COMPUTE if op is None else op.name))
            self.free[own] = now + self.period
            issue(now, thread)

        return noted

    def _next_task(self, next_task: Callable[[int, Thread], None]) -> Callable[[int, Thread], None]:
        def noted(now: int, thread: Thread) -> None:
            own = (thread.core, thread.index)
            if thread.has_task and own in self.begun:
                if self.shows(self.begun[own], now):
                    self.tasks[own].append(Span(self.begun[own], now, f"task {self.numbers[own]}"))
                del self.begun[own]
                self.numbers[own] += 1
            next_task(now, thread)
            if thread.has_task:
                self.begun[own] = now

        return noted

    def _reason(self, thread: Thread) -> str:
        if not isinstance(thread.reason, Wait):
            return {NO_WORK: "no work", LOCK: "lock"}[thread.reason]
        level = self.level(thread.reason, thread.ready_tick)
        return "dram" if level == self.num_caches else f"cache {level}"
