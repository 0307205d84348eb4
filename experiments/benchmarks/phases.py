"""The work that `archsim bench` plays, made once, to be played again and again: of each phase its machine and tasks.

It calls what checkouts of some time ago have too, so that `in_turn.py` can compare with them.
"""

from __future__ import annotations

from typing import NamedTuple

from archsim.bench import OVERRIDES, RUN
from archsim.config import load_run
from archsim.machine.build import phase_machine
from archsim.machine.compiled import simulate
from archsim.machine.counters import Counters
from archsim.machine.spec import MachineSpec
from archsim.run.izb_subject import subject_of
from archsim.run.izb_work import prepare, takes
from archsim.trace.records import Tasks, num_instructions
from archsim.trace.stream import Work


class Phase(NamedTuple):
    """Work of one phase of the light view with the most samples."""

    name: str
    spec: MachineSpec
    chunks: list[Tasks]
    instructions: int  # simulated

    def play(self, num_chunks: int | None = None) -> Counters:
        """Play all of it, or its first chunks."""
        chunks = self.chunks[:num_chunks]
        return simulate(self.spec, Work(sum(len(tasks.starts) - 1 for tasks in chunks), iter(chunks)))


def phases() -> list[Phase]:
    """Build and raster."""
    config = load_run(RUN, OVERRIDES)
    views = prepare(config.workload, takes(config), subject_of(config))
    view = max(views, key=lambda view: int(view.plan.face.taken.sum()))
    made = []
    for name, work in (("izb_build", view.build), ("izb_raster", view.raster)):
        chunks = list(work().chunks)
        spec = phase_machine(config.machine, name).spec
        made.append(Phase(name, spec, chunks, sum(num_instructions(tasks) for tasks in chunks)))
    return made
