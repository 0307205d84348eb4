"""Listening to the machines of a run while they play."""

from __future__ import annotations

from collections.abc import Callable

from archsim.machine.build import PhaseMachine
from archsim.machine.heard import NOTHING, Heard
from archsim.machine.pipeline.build import PipelineMachine

Listen = Callable[
    [str, PhaseMachine | PipelineMachine], Heard
]  # what of a phase, on that machine, is to be told


def to_nothing(phase: str, machine: PhaseMachine | PipelineMachine) -> Heard:
    """Let nobody be told anything."""
    return NOTHING
