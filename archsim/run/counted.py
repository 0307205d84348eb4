"""A phase played on cores, and the instructions counted that were executed for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from archsim.machine.build import PhaseMachine
from archsim.machine.counters import Counters
from archsim.machine.heard import NOTHING, Heard
from archsim.machine.play import play
from archsim.trace.records import Tasks, num_instructions
from archsim.trace.stream import Work


def play_counted(
    machine: PhaseMachine,
    work: Work,
    model: str,
    report: Callable[[int, int], None],
    heard: Heard = NOTHING,
) -> tuple[Counters, int]:
    """Counters of a phase, and the number of instructions that the kernel executed for it."""
    executed = [0]

    def counted() -> Iterator[Tasks]:
        for tasks in work.chunks:
            executed[0] += num_instructions(tasks)
            yield tasks

    counters = play(model, machine.spec, Work(work.num_tasks, counted()), report, heard)
    return counters, executed[0]
