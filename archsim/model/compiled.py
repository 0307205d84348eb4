"""What the compiled models share: how their steps are compiled, a time that never comes, queues by arrival, counts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from archsim.jit import njit

NEVER = 1 << 48  # the time of what will not happen; small enough to be multiplied by a period

# Steps are called by compiled code only, so they need no wrapper for Python: that halves the time to compile them.
# They work on arrays that are there already: see `compiled` in jit.py.
step = njit(error_model="numpy", _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True)
inlined_step = njit(
    error_model="numpy", _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True
)


def record(*fields: str, indices: Sequence[str] = ()) -> np.dtype:
    """The type of a record of integers. `indices` lie between 0 and 2**32 - 1: compiled code need not wrap them."""
    return np.dtype(
        [*((name, np.uint32) for name in indices), *((name, np.int64) for name in fields)], align=True
    )


def integers(spec: Any) -> Any:
    """A spec whose fields, enums and NumPy scalars too, are plain integers: one compilation serves all."""
    return type(spec)(*[integers(field) if isinstance(field, tuple) else int(field) for field in spec])


ENDS = record(indices=("head", "count", "mask"))


class QueueState(NamedTuple):
    """Q rings of records that have `arrival` and `rank`; ordered by arrival, then rank, then order of sending."""

    ends: np.ndarray  # ENDS [Q] slot of the oldest item, items in the ring, capacity - 1
    items: np.ndarray  # [Q, capacity] records, capacity a power of two


def new_queues(num_queues: int, capacity: int, dtype: np.dtype) -> QueueState:
    """Empty rings of at least `capacity` items each."""
    slots = 1 << max(1, (capacity - 1).bit_length())
    ends = np.zeros(num_queues, ENDS)
    ends["mask"] = slots - 1
    return QueueState(ends, np.zeros((num_queues, slots), dtype))


def grown(queues: QueueState) -> QueueState:
    """The same rings with twice the room."""
    num_queues, slots = queues.items.shape
    larger = new_queues(num_queues, 2 * slots, queues.items.dtype)
    for q, (head, count, _) in enumerate(queues.ends.tolist()):
        larger.items[q, :count] = np.roll(queues.items[q], -head)[:count]
        larger.ends["count"][q] = count
    return larger


@inlined_step
def num_items(queues, q):
    """Items in the ring."""
    return np.int64(queues.ends[q]["count"])


@inlined_step
def slot_of(queues, q, position):
    """Slot of the item that has `position` older items before it."""
    return np.uint32((position + queues.ends[q]["head"]) & np.int64(queues.ends[q]["mask"]))


@inlined_step
def oldest(queues, q):
    """The first item of the ring; what it says means nothing if there is none."""
    return queues.items[q, queues.ends[q]["head"]]


@step
def insert(queues, q, arrival, rank):
    """Slot of a new item, placed behind all that arrive no later (equal arrival: no higher rank)."""
    position = num_items(queues, q)
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


@inlined_step
def drop_oldest(queues, q):
    """Take out the first item."""
    queues.ends[q]["head"] = slot_of(queues, q, 1)
    queues.ends[q]["count"] -= 1


@step
def remove(queues, q, position):
    """Take out the item at `position`; the older ones move up."""
    for i in range(position, 0, -1):
        queues.items[q, slot_of(queues, q, i)] = queues.items[q, slot_of(queues, q, i - 1)]
    drop_oldest(queues, q)


REGISTERED = record("count", "before", "changed")  # a count, what it was before cycle `changed`


@inlined_step
def add_now(counts, number, cycle, amount):
    """The count grows in `cycle`; others see that from the next one on."""
    one = counts[number]
    if one["changed"] != cycle:
        one["before"] = one["count"]
        one["changed"] = cycle
    one["count"] += amount


@inlined_step
def seen(counts, number, cycle):
    """The count as others see it in `cycle`."""
    one = counts[number]
    return one["before"] if one["changed"] == cycle else one["count"]


def new_counts(num_counts: int) -> np.ndarray:
    """REGISTERED [n]: all zero."""
    counts = np.zeros(num_counts, REGISTERED)
    counts["changed"] = -1
    return counts
