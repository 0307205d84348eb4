"""The source of tasks as an in-order stage, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.model.compiled import step


class SourceState(NamedTuple):
    """What the source remembers."""

    ready: np.ndarray  # [1] earliest core cycle at which it can make the next task


def new_source() -> SourceState:
    """A source that can make its first task in cycle 0."""
    return SourceState(np.zeros(1, np.int64))


@step
def start_interval(spec, state, cycle):
    """A task was made in `cycle`; the next one takes the interval."""
    state.ready[0] = cycle + spec.interval_cycles
