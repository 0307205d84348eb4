"""The clockwork of every reference model: SimPy events ordered by tick, phase and index, never by chance."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from enum import IntEnum

import simpy
from simpy.events import EventPriority

_INDICES = 1 << 20  # more than any phase has components


class Phase(IntEnum):
    """What happens first within one tick; machine/README.md says why."""

    SAMPLE = 0  # counts are told, if at all
    FILL = 1  # data comes back
    SOURCE = 2  # the source makes a task
    ISSUE = 3  # cores issue, by core index
    ARRIVE = 4  # requests join the queue they were sent to, by sender
    LOOKUP = 5  # caches look up, by cache index
    COMMAND = 6  # channels issue commands, by channel index
    END = 7  # the tick is over


def at(env: simpy.Environment, tick: int, phase: Phase, index: int = 0) -> simpy.Event:
    """The event that comes at `tick` in `phase`, after those of a smaller index: `yield at(...)`.

    Events of one tick, phase and index come in the order in which they were asked for.
    """
    event = simpy.Event(env)
    event._ok, event._value = True, None  # triggered, as simpy.Timeout does it
    env.schedule(event, EventPriority(phase * _INDICES + index), tick - env.now)
    return event


class Registered:
    """A count that others see as it was before the current tick."""

    def __init__(self) -> None:
        self.count = 0
        self._before = 0
        self._tick = -1

    def add(self, now: int, amount: int) -> None:
        if now != self._tick:
            self._before, self._tick = self.count, now
        self.count += amount

    def seen(self, now: int) -> int:
        return self._before if now == self._tick else self.count


class Stays:
    """How long things were somewhere that they leave in the order in which they came."""

    def __init__(self) -> None:
        self.inside: deque[tuple[int, int]] = deque()  # tick of coming, and how much came
        self.left = 0  # ticks, summed over what left

    def come(self, now: int, amount: int) -> None:
        self.inside.append((now, amount))

    def leave(self, now: int) -> None:
        came, amount = self.inside.popleft()
        self.left += (now - came) * amount

    def ticks(self, now: int) -> int:
        """Summed over what left and what is inside."""
        return self.left + sum((now - came) * amount for came, amount in self.inside)


def call(event: simpy.Event, function: Callable[..., None], *arguments: object) -> None:
    """Call `function(*arguments)` when `event` comes."""
    assert event.callbacks is not None
    event.callbacks.append(lambda _: function(*arguments))


def stop_at(env: simpy.Environment, tick: int) -> None:
    """End the run in that tick, if it lasts so long."""
    end = env.timeout(tick - env.now)
    assert end.callbacks is not None
    end.callbacks.append(simpy.core.StopSimulation.callback)
