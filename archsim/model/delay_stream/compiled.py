"""Delay streams, compiled: offsets into endless streams of bytes, of which the rings hold a part.

What asks the memory is the machine's business: here a transfer is a number that is done at some time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.model.compiled import add_now, inlined_step, new_counts, record, seen, step
from archsim.model.delay_stream.spec import DelayStreamSpec, Overflow

WRITES, READS = 0, 1  # directions of a transfer
NO_TRANSFER = -1

_STREAM_FIELDS = (
    *DelayStreamSpec._fields,
    "num_put",  # items
    "num_taken",
    "num_released",  # items whose bytes are released
    "sent",  # bytes sent to the memory
    "written",  # bytes that are there
    "asked",  # bytes asked of the memory
    "peak",  # most bytes held
    "stayed",  # cycles in which bytes were taken less those in which they were put in
    "marks",
    "early",  # items released by overflow
)
_TRANSFERS_FIELDS = ("oldest", "next")  # number of the oldest transfer under way, of the next one
STREAM = record(*_STREAM_FIELDS)
TRANSFERS = record(*_TRANSFERS_FIELDS)
TRANSFER = record("end", "is_done")  # first byte behind it


class StreamsState(NamedTuple):
    """D delay streams. Counts of bytes are from the start of the run."""

    streams: np.ndarray  # STREAM [D]
    pushed: np.ndarray  # REGISTERED [D] bytes put in
    released: np.ndarray  # REGISTERED [D] bytes that may pass
    read: np.ndarray  # REGISTERED [D] bytes that came back
    taken: np.ndarray  # REGISTERED [D] bytes of items that were taken
    ends: np.ndarray  # [D, capacity] ring of the first byte behind each item; capacity a power of two
    transfers: np.ndarray  # TRANSFERS [D, 2] writes and reads so far
    under_way: np.ndarray  # TRANSFER [D, 2, slots] ring; a power of two


def new_streams(specs: Sequence[DelayStreamSpec]) -> StreamsState:
    """All empty."""
    num = len(specs)
    streams = np.zeros(num, STREAM)
    for name in DelayStreamSpec._fields:
        streams[name] = [getattr(spec, name) for spec in specs]
    capacity = 1 << max((spec.ring_bytes for spec in specs), default=0).bit_length()
    slots = 1 << max((spec.outstanding for spec in specs), default=0).bit_length()
    return StreamsState(
        streams=streams,
        pushed=new_counts(num),
        released=new_counts(num),
        read=new_counts(num),
        taken=new_counts(num),
        ends=np.zeros((num, capacity), np.int64),
        transfers=np.zeros((num, 2), TRANSFERS),
        under_way=np.zeros((num, 2, slots), TRANSFER),
    )


@inlined_step
def _end_of(state, number, item):
    """First byte behind the item."""
    return state.ends[number, item & (state.ends.shape[1] - 1)]


@inlined_step
def has_item(state, cycle, number):
    """Whether an item can be taken in `cycle`."""
    stream = state.streams[number]
    if stream["num_taken"] == stream["num_put"]:
        return False
    return _end_of(state, number, stream["num_taken"]) <= seen(state.read, number, cycle)


@step
def coming(state, cycle, number):
    """The transfer under way before `cycle` that brings the first byte that is not here, as direction and slot in one.

    NO_TRANSFER if that byte may not pass, or is not on its way.
    """
    stream, transfers = state.streams[number], state.transfers[number]
    here, slots = seen(state.read, number, cycle), state.under_way.shape[2]
    if seen(state.released, number, cycle) <= here:
        return NO_TRANSFER
    if transfers[READS]["oldest"] < transfers[READS]["next"]:
        return READS * slots + (transfers[READS]["oldest"] & (slots - 1))
    if transfers[WRITES]["oldest"] < transfers[WRITES]["next"] and stream["written"] <= here:
        return WRITES * slots + (transfers[WRITES]["oldest"] & (slots - 1))
    return NO_TRANSFER


@inlined_step
def take(state, cycle, number):
    """The oldest item leaves in `cycle`."""
    stream = state.streams[number]
    num_bytes = _end_of(state, number, stream["num_taken"]) - state.taken[number]["count"]
    add_now(state.taken, number, cycle, num_bytes)
    stream["num_taken"] += 1
    stream["stayed"] += cycle * num_bytes


@step
def put(state, cycle, number, num_bytes):
    """Whether an item has room in `cycle`; then it is put in."""
    stream = state.streams[number]
    end = state.pushed[number]["count"] + num_bytes
    if stream["overflow"] == Overflow.RELEASE:
        _release_early(state, cycle, number, end - stream["ring_bytes"])
    held = end - seen(state.taken, number, cycle)
    if held > stream["ring_bytes"]:
        return False

    add_now(state.pushed, number, cycle, num_bytes)
    state.ends[number, stream["num_put"] & (state.ends.shape[1] - 1)] = end
    stream["num_put"] += 1
    stream["peak"] = max(stream["peak"], held)
    stream["stayed"] -= cycle * num_bytes
    return True


@step
def _release_early(state, cycle, number, least):
    """Release in `cycle` as few items as bring the released bytes to `least`."""
    stream = state.streams[number]
    while state.released[number]["count"] < least:
        end = _end_of(state, number, stream["num_released"])
        add_now(state.released, number, cycle, end - state.released[number]["count"])
        stream["num_released"] += 1
        stream["early"] += 1


@step
def mark(state, cycle, number):
    """Everything that is here may pass."""
    stream = state.streams[number]
    amount = state.pushed[number]["count"] - state.released[number]["count"]
    add_now(state.released, number, cycle, amount)
    stream["num_released"] = stream["num_put"]
    stream["marks"] += 1


@inlined_step
def _line_end(stream, offset):
    return (offset // stream["line_bytes"] + 1) * stream["line_bytes"]


@step
def write_end(state, cycle, number):
    """Where the write that is sent in `cycle` ends; `sent` if none is."""
    stream, transfers = state.streams[number], state.transfers[number, WRITES]
    end = _line_end(stream, stream["sent"])
    if seen(state.pushed, number, cycle) < end:
        end = seen(state.released, number, cycle)
    is_free = transfers["next"] - transfers["oldest"] < stream["outstanding"]
    return max(end, stream["sent"]) if is_free else stream["sent"]


@step
def read_end(state, cycle, number):
    """Where the read that is asked for in `cycle` ends; `asked` if none is."""
    stream, transfers = state.streams[number], state.transfers[number, READS]
    end = min(_line_end(stream, stream["asked"]), min(seen(state.released, number, cycle), stream["written"]))
    is_free = transfers["next"] - transfers["oldest"] < stream["outstanding"]
    is_wanted = stream["asked"] - seen(state.taken, number, cycle) < stream["prefetch_bytes"]
    return max(end, stream["asked"]) if is_free and is_wanted else stream["asked"]


@step
def begin(state, number, direction, end):
    """A transfer that ends at `end` begins; returns its slot."""
    transfers = state.transfers[number, direction]
    slot = transfers["next"] & (state.under_way.shape[2] - 1)
    state.under_way[number, direction, slot]["end"] = end
    state.under_way[number, direction, slot]["is_done"] = 0
    transfers["next"] += 1
    stream = state.streams[number]
    if direction == WRITES:
        stream["sent"] = end
    else:
        stream["asked"] = end
    return slot


@step
def finish(state, cycle, number, direction, slot):
    """The transfer in this slot is done in `cycle`; bytes count when all before them are done, too."""
    transfers, under_way = state.transfers[number, direction], state.under_way[number, direction]
    under_way[slot]["is_done"] = 1
    while transfers["oldest"] < transfers["next"]:
        oldest = under_way[transfers["oldest"] & (len(under_way) - 1)]
        if oldest["is_done"] == 0:
            break
        transfers["oldest"] += 1
        if direction == WRITES:
            state.streams[number]["written"] = oldest["end"]
        else:
            add_now(state.read, number, cycle, oldest["end"] - state.read[number]["count"])
