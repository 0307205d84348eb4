"""How requests enter the windows of the compiled DRAM: forwarded, or classified and put into a list."""

from __future__ import annotations

import numpy as np

from archsim.model.compiled import NEVER, drop_oldest, inlined_step, num_items, oldest, slot_of, step
from archsim.model.dram.compiled_commands import field_of, note_wishes
from archsim.model.dram.compiled_plan import overtakes
from archsim.model.dram.compiled_state import CLOSED, NO_REQUESTER, NOBODY, PLAN_AGAIN, WRITES
from archsim.model.dram.compiled_waits import served_at


@inlined_step
def ring_of(spec, channel, is_write):
    """The ring of a channel's reads or writes."""
    return np.uint32(channel + spec.num_channels if is_write and spec.num_write_entries > 0 else channel)


@inlined_step
def num_in_window(spec, channel, is_write):
    """Requests in the window that a request joins."""
    if spec.num_write_entries == 0:
        return np.int64(channel["num_reads"]) + np.int64(channel["num_writes"])
    return np.int64(channel["num_writes"] if is_write else channel["num_reads"])


@inlined_step
def next_entry(spec, state, number):
    """The clock in which the next request may enter a window, or NEVER."""
    channel, reads, writes = state.channels[number], number, np.uint32(number + spec.num_channels)
    due = NEVER
    if num_items(state.queue, reads) > 0 and num_in_window(spec, channel, False) < spec.num_queue_entries:
        due = oldest(state.queue, reads)["clock"]
    has_writes = spec.num_write_entries > 0 and num_items(state.queue, writes) > 0
    if has_writes and channel["num_writes"] < spec.num_write_entries:
        due = min(due, oldest(state.queue, writes)["clock"])
    return due


@inlined_step
def enter(spec, state, clock, number):
    """Let what has come by `clock` into the windows; at a read that can be forwarded, stop and return its requester."""
    channel, reads, writes = state.channels[number], number, np.uint32(number + spec.num_channels)
    while num_items(state.queue, reads) > 0 and num_in_window(spec, channel, False) < spec.num_queue_entries:
        request = oldest(state.queue, reads)
        if request["clock"] > clock:
            break
        if spec.num_write_entries > 0 and _can_forward(spec, state, number, request):
            channel["forwarded"] += 1
            channel["forwarded_bytes"] += request["bursts"] * spec.burst_beats * spec.beat_bytes
            channel["data_beats"] = (clock + 1) * spec.clock_beats
            served_at(state, number, NEVER)
            channel["waited_clocks"] += clock - request["clock"]
            drop_oldest(state.queue, reads)
            return request["requester"]
        _take(spec, state, clock, number, request)
        drop_oldest(state.queue, reads)
    while channel["num_writes"] < spec.num_write_entries and num_items(state.queue, writes) > 0:
        request = oldest(state.queue, writes)
        if request["clock"] > clock:
            break
        _take(spec, state, clock, number, request)
        drop_oldest(state.queue, writes)
    return NO_REQUESTER


@inlined_step
def bank_of(spec, address):
    """The bank of an address within its channel."""
    number = field_of(address, spec.bank) * spec.num_groups + field_of(address, spec.group)
    return np.uint32(number ^ (field_of(address, spec.row) & ((1 << spec.bank_hash) - 1)))


@inlined_step
def _take(spec, state, clock, number, request):
    """Put a request into a free slot and at the end of its bank's list, and count what it finds there."""
    channel = state.channels[number]
    slot = channel["free"]
    waiting = state.waiting[number, slot]
    channel["free"] = waiting["next"]
    bank_number, row = bank_of(spec, request["address"]), field_of(request["address"], spec.row)
    waiting["number"], waiting["next"] = channel["entered"], NOBODY
    waiting["bank"], waiting["row"] = bank_number, row
    waiting["arrival"], waiting["rank"], waiting["order"] = (
        request["arrival"],
        request["rank"],
        request["order"],
    )
    waiting["clock"], waiting["address"] = request["clock"], request["address"]
    waiting["requester"], waiting["bursts"] = request["requester"], request["bursts"]
    waiting["is_write"] = request["is_write"]
    channel["entered"] += 1
    if request["is_write"] != 0:
        channel["num_writes"] += 1
    else:
        channel["num_reads"] += 1
    _append(state, number, bank_number, slot)
    if overtakes(spec, state, clock, number, slot):
        channel["plan"], channel["plan_due"] = PLAN_AGAIN, clock
    _classify(channel, state.banks[number, bank_number]["open_row"], row)


@inlined_step
def _append(state, number, bank_number, slot):
    """Put the request at the end of its list."""
    waiting = state.waiting[number, slot]
    requests = state.lists[number, bank_number, waiting["is_write"]]
    if requests["first"] == NOBODY:
        requests["first"], requests["first_key"] = slot, waiting["number"]
    else:
        state.waiting[number, requests["last"]]["next"] = slot
    requests["last"] = slot
    if requests["hit"] == NOBODY and state.banks[number, bank_number]["open_row"] == waiting["row"]:
        requests["hit"], requests["hit_key"] = slot, waiting["number"]
    note_wishes(state, number, bank_number)


@inlined_step
def _classify(channel, open_row, row):
    """Count what a request finds in its bank."""
    if open_row == CLOSED:
        channel["row_misses"] += 1
    elif open_row == row:
        channel["row_hits"] += 1
    else:
        channel["row_conflicts"] += 1


@step
def _can_forward(spec, state, number, read):
    """Whether a write that came before the read and still waits holds its data."""
    slot = state.lists[number, bank_of(spec, read["address"]), WRITES]["first"]
    while slot != NOBODY:
        if _holds(state.waiting[number, slot], read):
            return True
        slot = state.waiting[number, slot]["next"]
    ring = number + spec.num_channels
    for position in range(num_items(state.queue, ring)):
        if _holds(state.queue.items[ring, slot_of(state.queue, ring, position)], read):
            return True
    return False


@inlined_step
def _holds(write, read):
    """Whether the write came before the read and holds its data."""
    if write["address"] != read["address"] or write["bursts"] < read["bursts"]:
        return False
    if write["arrival"] != read["arrival"]:
        return write["arrival"] < read["arrival"]
    if write["rank"] != read["rank"]:
        return write["rank"] < read["rank"]
    return write["order"] < read["order"]
