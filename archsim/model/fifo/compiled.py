"""Bounded queues as rings: the fifo between the source and the cores, and queues ordered by arrival."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.model.fifo.spec import FifoSpec

NEVER = 1 << 48  # the time of what will not happen; small enough to be multiplied by a period


class FifoState(NamedTuple):
    """The fifo's items are consecutive task numbers, so its two ends say all."""

    ends: np.ndarray  # [2] next task to take, next task to be made


def new_fifo() -> FifoState:
    """An empty fifo whose first item will be task 0."""
    return FifoState(np.zeros(2, np.int64))


@njit
def num_queued(state):
    """Items in the fifo."""
    return state.ends[1] - state.ends[0]


@njit
def has_room(spec, state):
    """Whether the producer may push."""
    return num_queued(state) < spec.num_entries


class QueueState(NamedTuple):
    """Q rings of records that have a field `arrival`; a ring is ordered by arrival, then rank, then order of sending."""

    head: np.ndarray  # [Q] slot of the oldest item
    count: np.ndarray  # [Q] items in the ring
    items: np.ndarray  # [Q, capacity] records, capacity a power of two


def new_queues(num_queues: int, capacity: int, dtype: np.dtype) -> QueueState:
    """Empty rings of at least `capacity` items each."""
    slots = 1 << max(1, (capacity - 1).bit_length())
    zeros = np.zeros(num_queues, np.int64)
    return QueueState(zeros, zeros.copy(), np.zeros((num_queues, slots), dtype))


def grown(queues: QueueState) -> QueueState:
    """The same rings with twice the room."""
    larger = new_queues(len(queues.head), 2 * queues.items.shape[1], queues.items.dtype)
    for q, (head, count) in enumerate(zip(queues.head, queues.count, strict=True)):
        larger.items[q, :count] = np.roll(queues.items[q], -head)[:count]
    larger.count[:] = queues.count
    return larger


@njit(forceinline=True)
def slot_of(queues, q, position):
    """Slot of the item that has `position` older items before it."""
    return (queues.head[q] + position) & (queues.items.shape[1] - 1)


@njit
def insert(queues, q, arrival, rank):
    """Slot of a new item, placed behind all that arrive no later (equal arrival: no higher rank)."""
    position = queues.count[q]
    queues.count[q] += 1
    slot = slot_of(queues, q, position)
    while position > 0:
        before = slot_of(queues, q, position - 1)
        older = queues.items[q, before]
        if older["arrival"] < arrival or (older["arrival"] == arrival and older["rank"] <= rank):
            break
        queues.items[q, slot] = older
        slot = before
        position -= 1
    queues.items[q, slot]["arrival"] = arrival
    queues.items[q, slot]["rank"] = rank
    return slot


@njit
def remove(queues, q, position):
    """Take out the item at `position`; the older ones move up."""
    for i in range(position, 0, -1):
        queues.items[q, slot_of(queues, q, i)] = queues.items[q, slot_of(queues, q, i - 1)]
    queues.head[q] = slot_of(queues, q, 1)
    queues.count[q] -= 1
