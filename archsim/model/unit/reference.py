"""The source of tasks, to be believed: a process that looks at every core edge whether it can make one."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator
from typing import Any

import simpy

from archsim.model.fifo.reference import Fifo
from archsim.model.reference import Phase, at
from archsim.model.unit.spec import UnitSpec


class Source:
    """Makes one task every `interval_cycles` for the thread that idles longest, else for the fifo."""

    def __init__(
        self, spec: UnitSpec, env: simpy.Environment, period_ticks: int, tasks: list[Any], fifo: Fifo
    ):
        self.spec, self.env, self.period_ticks = spec, env, period_ticks
        self.unmade = deque(tasks)
        self.fifo = fifo
        self.idle: deque[Any] = deque()  # threads, the longest idle one first

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: at every core edge, end of phase 0."""
        tick = ready_tick = 0
        while self.unmade:
            yield at(self.env, tick, Phase.SOURCE)
            if tick >= ready_tick and self.can_make():
                self._make(tick)
                ready_tick = tick + self.spec.interval_cycles * self.period_ticks
            tick += self.period_ticks

    def take(self, thread: Any) -> Any:
        """The task at the head of the fifo; None when there is none: `thread` idles or retires."""
        if not self.fifo.is_empty():
            return self.fifo.pop()
        if self.unmade:
            thread.idle()
            self.idle.append(thread)
        else:
            thread.retire()
        return None

    def can_make(self) -> bool:
        """Whether there is a task to make and a place to put it."""
        return bool(self.unmade) and (bool(self.idle) or not self.fifo.is_full())

    def _make(self, now: int) -> None:
        task = self.unmade.popleft()
        if self.idle:
            self.idle.popleft().hand(now, task)
        else:
            self.fifo.push(task)

        if not self.unmade:
            for thread in self.idle:
                thread.retire()
            self.idle.clear()
