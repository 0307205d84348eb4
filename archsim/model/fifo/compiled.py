"""Fifos, compiled: the one between the source and the cores, and those between two units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.model.compiled import add_now, inlined_step, new_counts, record, seen, step
from archsim.model.fifo.spec import FifoSpec


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


_PIPE_FIELDS = (
    "num_entries",
    "peak",  # most items held
    "stayed",  # cycles in which items were taken less those in which they were put in
)
PIPE = record(*_PIPE_FIELDS)


class PipesState(NamedTuple):
    """F fifos between units. Their items are known to the algorithm, so they are counted only."""

    pipes: np.ndarray  # PIPE [F]
    put_in: np.ndarray  # REGISTERED [F]
    taken: np.ndarray  # REGISTERED [F]


def new_pipes(specs: Sequence[FifoSpec]) -> PipesState:
    """All empty."""
    pipes = np.zeros(len(specs), PIPE)
    pipes["num_entries"] = [spec.num_entries for spec in specs]
    return PipesState(pipes, new_counts(len(specs)), new_counts(len(specs)))


@inlined_step
def has_item(state, cycle, number):
    """Whether an item can be taken in `cycle`."""
    return seen(state.put_in, number, cycle) > state.taken[number]["count"]


@inlined_step
def take(state, cycle, number):
    """The oldest item leaves in `cycle`."""
    add_now(state.taken, number, cycle, 1)
    state.pipes[number]["stayed"] += cycle


@step
def put(state, cycle, number):
    """Whether an item has room in `cycle`; then it is put in."""
    pipe = state.pipes[number]
    held = state.put_in[number]["count"] - seen(state.taken, number, cycle)
    if held >= pipe["num_entries"]:
        return False
    add_now(state.put_in, number, cycle, 1)
    pipe["stayed"] -= cycle
    pipe["peak"] = max(pipe["peak"], held + 1)
    return True
