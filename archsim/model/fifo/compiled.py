"""Bounded queues as rings: the fifo between the source and the cores, and queues ordered by arrival; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import compiled, inlined

NEVER = 1 << 48  # the time of what will not happen; small enough to be multiplied by a period


class FifoState(NamedTuple):
    """The fifo's items are consecutive task numbers, so its two ends say all."""

    ends: np.ndarray  # [2] next task to take, next task to be made


def new_fifo() -> FifoState:
    """An empty fifo whose first item will be task 0."""
    return FifoState(np.zeros(2, np.int64))


@compiled
def num_queued(state):
    """Items in the fifo."""
    return state.ends[1] - state.ends[0]


@compiled
def has_room(spec, state):
    """Whether the producer may push."""
    return num_queued(state) < spec.num_entries


ENDS = np.dtype([("head", np.int64), ("count", np.int64)], align=True)


class QueueState(NamedTuple):
    """Q rings of records that have `arrival` and `rank`; ordered by arrival, then rank, then order of sending."""

    ends: np.ndarray  # ENDS [Q] slot of the oldest item, items in the ring
    items: np.ndarray  # [Q, capacity] records, capacity a power of two


def new_queues(num_queues: int, capacity: int, dtype: np.dtype) -> QueueState:
    """Empty rings of at least `capacity` items each."""
    slots = 1 << max(1, (capacity - 1).bit_length())
    return QueueState(np.zeros(num_queues, ENDS), np.zeros((num_queues, slots), dtype))


def grown(queues: QueueState) -> QueueState:
    """The same rings with twice the room."""
    num_queues, slots = queues.items.shape
    larger = new_queues(num_queues, 2 * slots, queues.items.dtype)
    for q, (head, count) in enumerate(queues.ends.tolist()):
        larger.items[q, :count] = np.roll(queues.items[q], -head)[:count]
        larger.ends["count"][q] = count
    return larger


@inlined
def num_items(queues, q):
    """Items in the ring."""
    return queues.ends[q]["count"]


@inlined
def slot_of(queues, q, position):
    """Slot of the item that has `position` older items before it."""
    return (queues.ends[q]["head"] + position) & (queues.items.shape[1] - 1)


@inlined
def oldest(queues, q):
    """The first item of the ring; what it says means nothing if there is none."""
    return queues.items[q, queues.ends[q]["head"]]


@compiled
def insert(queues, q, arrival, rank):
    """Slot of a new item, placed behind all that arrive no later (equal arrival: no higher rank)."""
    position = queues.ends[q]["count"]
    queues.ends[q]["count"] += 1
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


@compiled
def remove(queues, q, position):
    """Take out the item at `position`; the older ones move up."""
    for i in range(position, 0, -1):
        queues.items[q, slot_of(queues, q, i)] = queues.items[q, slot_of(queues, q, i - 1)]
    queues.ends[q]["head"] = slot_of(queues, q, 1)
    queues.ends[q]["count"] -= 1
