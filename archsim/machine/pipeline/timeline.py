"""What the units of a pipeline did when: recorded from the reference model, like a timeline of cores."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from archsim.machine.pipeline.reference import Machine
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.machine.timeline import ALL, NEVER, MemoryRecorder, Place, Span, Timeline, Window, between
from archsim.model.unit.reference import Stage
from archsim.model.unit.spec import Slot

DOES = {slot: slot.name.lower().replace("_", " ") for slot in Slot}


class PipelineRecorder(MemoryRecorder):
    """Notes what the fronts of units do, and how full fifos and delay streams are, in a window of cycles."""

    def __init__(self, spec: PipelineSpec, window: Window = ALL):
        super().__init__(spec.period_ticks, len(spec.caches), spec.dram, window)
        self.does: dict[Place, list[Span]] = {}
        self.tasks: dict[Place, list[Span]] = {}
        self.held: list[tuple[int, int, int]] = []
        self.numbers: Counter[Place] = Counter()  # tasks of each unit

    def attach(self, machine: Machine) -> None:
        """Begin to note."""
        for unit in machine.units:
            self.does[unit.index, 0], self.tasks[unit.index, 0] = [], []
            between(unit, "_front", partial(self._front, unit))
            between(unit, "_end", partial(self._end, unit))
        for number, channel in enumerate([*machine.fifos, *machine.streams]):
            between(channel, "put", partial(self._put, number, channel))
            between(channel, "take", partial(self._take, number, channel))
        self.attach_memory(machine)

    def timeline(self) -> Timeline:
        """What was noted."""
        return Timeline(
            self.period,
            self.dram.period_ticks,
            [],
            self.does,
            self.tasks,
            self.accesses,
            self.commands,
            self.queues,
            self.held,
        )

    def _front(self, unit: Stage, front: Callable[[int], Slot]) -> Callable[[int], Slot]:
        spans = self.does[unit.index, 0]

        def noted(now: int) -> Slot:
            slot = front(now)
            end, does = now + self.period, DOES[slot]
            if self.shows(now, now):
                if spans and spans[-1].end == now and spans[-1].name == does:
                    spans[-1] = Span(spans[-1].start, end, does)
                else:
                    spans.append(Span(now, end, does))
            return slot

        return noted

    def _end(self, unit: Stage, end: Callable[[int], Slot | None]) -> Callable[[int], Slot | None]:
        own = (unit.index, 0)

        def noted(now: int) -> Slot | None:
            began = unit.began
            hindered = end(now)
            if hindered is None:
                if self.shows(began, now):
                    self.tasks[own].append(Span(began, now, f"task {self.numbers[own]}"))
                self.numbers[own] += 1
            return hindered

        return noted

    def _put(self, number: int, channel: Any, put: Callable[[int, int], bool]) -> Callable[[int, int], bool]:
        def noted(now: int, num_bytes: int) -> bool:
            has_room = put(now, num_bytes)
            self._note(now, number, channel)
            return has_room

        return noted

    def _take(self, number: int, channel: Any, take: Callable[[int], None]) -> Callable[[int], None]:
        def noted(now: int) -> None:
            take(now)
            self._note(now, number, channel)

        return noted

    def _note(self, now: int, number: int, channel: Any) -> None:
        """How much is in a fifo or delay stream."""
        put = channel.put_in if hasattr(channel, "put_in") else channel.pushed
        if self.shows(now, now):
            self.held.append((now, number, put.count - channel.taken.count))


class TaskRecorder(PipelineRecorder):
    """Notes the same from the cycle in which the first of some tasks begins to that in which the last one ends."""

    def __init__(self, spec: PipelineSpec, tasks: Window, units: Sequence[int]):
        """`tasks`: numbers of each of the `units`' tasks."""
        super().__init__(spec)
        self.chosen, self.units = tasks, units
        self.left = set(units)  # those that are not through
        self.first = NEVER  # not begun
        self.latest = 0  # tick of what was noted last

    def attach(self, machine: Machine) -> None:
        """Begin to wait for the tasks."""
        super().attach(machine)
        for number in self.units:
            unit = machine.units[number]
            if not unit.inputs:
                self._begin(0, unit)
            between(unit, "_opened" if unit.inputs else "_end", partial(self._begins, unit))
            between(unit, "_front", partial(self._follow, machine, unit))

    def window(self) -> Window | None:
        """The cycles that were noted; None if there are no such tasks."""
        if all(self.numbers[unit, 0] <= self.chosen.first for unit in self.units):
            return None
        return Window(self.first // self.period, self.last // self.period)

    def shows(self, start: int, end: int) -> bool:
        """Whether it is within the window; before that begins, only what happens in the same tick may be."""
        if self.first < NEVER:
            return super().shows(start, end)
        if end > self.latest:
            self._forget()
        self.latest = end
        return True

    def _forget(self) -> None:
        """Nothing noted so far will be shown."""
        noted: list[list[Any]] = [*self.does.values(), *self.tasks.values()]
        noted += [self.accesses, self.commands, self.queues, self.held]
        for some in noted:
            some.clear()

    def _begin(self, now: int, unit: Stage) -> None:
        """The unit's task begins now, if it is one of those, or did before."""
        if self.numbers[unit.index, 0] >= self.chosen.first:
            self.first = min(self.first, now)

    def _begins(self, unit: Stage, step: Callable[[int], Any]) -> Callable[[int], Any]:
        def noted(now: int) -> Any:
            done = step(now)
            self._begin(now, unit)
            return done

        return noted

    def _follow(self, machine: Machine, unit: Stage, front: Callable[[int], Slot]) -> Callable[[int], Slot]:
        def noted(now: int) -> Slot:
            slot = front(now)
            if unit.record is None or self.numbers[unit.index, 0] >= self.chosen.last:
                self.left.discard(unit.index)
            if not self.left and self.last == NEVER:
                self.last = now + self.period
                self.stop_behind(machine.env)
            return slot

        return noted
