"""What the units of a pipeline did when: recorded from the reference model, like a timeline of cores."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

from archsim.machine.pipeline.reference import Machine
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.machine.timeline import ALL, MemoryRecorder, Place, Span, Timeline, Window, between
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
