"""The fifo between the source and the cores, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.model.compiled import inlined_step


class FifoState(NamedTuple):
    """The fifo's items are consecutive task numbers, so its two ends say all."""

    ends: np.ndarray  # [2] next task to take, next task to be made


def new_fifo() -> FifoState:
    """An empty fifo whose first item will be task 0."""
    return FifoState(np.zeros(2, np.int64))


@inlined_step
def num_queued(state):
    """Items in the fifo."""
    return state.ends[1] - state.ends[0]


@inlined_step
def has_room(spec, state):
    """Whether the producer may push."""
    return num_queued(state) < spec.num_entries
