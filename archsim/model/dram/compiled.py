"""Channels of a DRAM with banks, rows, buses, refresh and schedulers, compiled.

A channel is woken only at memory clocks at which something can happen. Waking it too early does no harm.
"""

from __future__ import annotations

import numpy as np

from archsim.model.compiled import NEVER, drop_oldest, inlined_step, insert, num_items, oldest, step
from archsim.model.dram.commands import CommandSink
from archsim.model.dram.compiled_commands import activate, column, field_of, precharge, refresh
from archsim.model.dram.compiled_plan import drains, plan
from archsim.model.dram.compiled_state import (
    CLOSED,
    COLUMN,
    NO_REQUESTER,
    PLAN_AGAIN,
    REFRESH,
    ROW,
    DramState,
    new_dram,
    recording,
)
from archsim.model.dram.compiled_waits import served_at
from archsim.model.dram.compiled_window import enter, next_entry, num_in_window, ring_of
from archsim.model.dram.spec import Scheduler

__all__ = [
    "NO_REQUESTER",
    "DramState",
    "answer_cycle",
    "channel_of",
    "find_next_due",
    "has_room",
    "is_empty",
    "is_idle",
    "is_log_half_full",
    "new_dram",
    "next_due",
    "recording",
    "ring_of_request",
    "send",
    "take_log",
    "wake",
]

_IDEAL = int(Scheduler.IDEAL)


@inlined_step
def channel_of(spec, address):
    """The channel of an address."""
    return np.uint32(field_of(address, spec.channel))


@inlined_step
def ring_of_request(spec, address, is_write):
    """The ring of `queue` that a request joins."""
    return ring_of(spec, channel_of(spec, address), is_write)


@inlined_step
def send(spec, state, arrival_ticks, address, rank, is_write):
    """Queue a request that arrives at `arrival_ticks`; returns it, for the sender to give its bursts and requester."""
    number = channel_of(spec, address)
    ring = ring_of(spec, number, is_write)
    slot = insert(state.queue, ring, arrival_ticks, rank)
    request = state.queue.items[ring, slot]
    request["address"] = address
    request["is_write"] = is_write
    request["clock"] = (arrival_ticks + spec.period_ticks - 1) // spec.period_ticks
    request["order"] = state.channels[number]["sent"]
    state.channels[number]["sent"] += 1
    state.due[number] = min(state.due[number], request["clock"])
    state.next_due[0] = min(state.next_due[0], request["clock"])
    return request


@inlined_step
def is_idle(spec, state, number):
    """Whether no request is queued at the channel or on its way to its queue."""
    channel, num_queued = state.channels[number], num_items(state.queue, number)
    if spec.num_write_entries > 0:
        num_queued += num_items(state.queue, number + spec.num_channels)
    return np.int64(channel["num_reads"]) + np.int64(channel["num_writes"]) + num_queued == 0


@step
def is_empty(spec, state):
    """Whether no request is queued or on its way to a queue."""
    for number in range(len(state.channels)):
        if not is_idle(spec, state, number):
            return False
    return True


@inlined_step
def has_room(spec, state, address, is_write):
    """Whether a request that came now would enter its window at once."""
    number = channel_of(spec, address)
    ring = ring_of(spec, number, is_write)
    size = spec.num_queue_entries if ring == number else spec.num_write_entries
    return num_in_window(spec, state.channels[number], is_write) + num_items(state.queue, ring) < size


@inlined_step
def is_log_half_full(state):
    """Whether it is time to take the recorded commands."""
    return 2 * state.log_size[0] > len(state.log)


def take_log(state: DramState, sink: CommandSink) -> None:
    """Hand over what has been recorded."""
    recorded, lost = state.log_size.tolist()
    assert lost == 0, "the log of DRAM commands was too small for what one step issues"
    log = state.log[:recorded]
    sink(log[np.argsort(log["clock"], kind="stable")])
    state.log_size[0] = 0


@inlined_step
def next_due(state):
    """The first clock at which a channel must be woken, or an earlier one."""
    return state.next_due[0]


@inlined_step
def find_next_due(state):
    """Find out when the first channel must be woken."""
    first = NEVER
    for number in range(len(state.due)):
        first = min(first, state.due[number])
    state.next_due[0] = first


@inlined_step
def wake(spec, state, number):
    """Play the clock at which the channel is due; returns who is answered, or NO_REQUESTER."""
    clock = state.due[number]
    if spec.scheduler == _IDEAL:
        requester, state.due[number] = _serve_first(spec, state, clock, number)
    else:
        requester, state.due[number] = _wake(spec, state, clock, number)
    return requester


@inlined_step
def _wake(spec, state, clock, number):
    """Play `clock`: entries, then the command that is planned. Stops at a read answered without a command.

    Returns who is answered, or NO_REQUESTER, and the clock at which the channel must be woken next.
    """
    channel = state.channels[number]
    if spec.num_write_entries > 0 and clock > channel["last_wake"] + 1:
        channel["is_draining"] = drains(spec, channel)  # as it was decided in the clocks between
    channel["last_wake"] = clock
    requester = enter(spec, state, clock, number)
    if requester != NO_REQUESTER:
        channel["plan"], channel["plan_due"] = PLAN_AGAIN, clock
        return requester, clock

    if spec.num_write_entries > 0:
        channel["is_draining"] = drains(spec, channel)
    if channel["plan"] == PLAN_AGAIN and channel["plan_due"] <= clock:
        plan(spec, state, clock, number)
    entry = next_entry(spec, state, number)
    if channel["plan"] != PLAN_AGAIN and channel["plan_due"] <= clock:
        requester = _carry_out(spec, state, clock, number)
        channel["plan"], channel["plan_due"] = PLAN_AGAIN, clock + 1
        entry = next_entry(spec, state, number)
        if entry > clock + 1:  # or else then is the time to plan
            plan(spec, state, clock + 1, number)
    return requester, min(channel["plan_due"], max(clock + 1, entry))


@inlined_step
def _carry_out(spec, state, clock, number):
    """Issue the planned command in `clock`; returns who is answered, or NO_REQUESTER."""
    channel = state.channels[number]
    command, bank, slot = channel["plan"], channel["plan_bank"], channel["plan_slot"]
    if command == COLUMN:
        return column(spec, state, clock, number, slot)
    if command == REFRESH:
        refresh(spec, state, clock, number)
    elif command == ROW and state.banks[number, bank]["open_row"] == CLOSED:
        activate(spec, state, clock, number, bank, state.waiting[number, slot]["row"])
    else:
        precharge(spec, state, clock, number, bank)
    return NO_REQUESTER


@step
def _serve_first(spec, state, clock, number):
    """IDEAL: serve the oldest request, as if its row were open; returns the same as `_wake`."""
    channel, requester = state.channels[number], NO_REQUESTER
    if num_items(state.queue, number) > 0 and oldest(state.queue, number)["clock"] <= clock:
        request = oldest(state.queue, number)
        channel["row_hits"] += 1
        channel["data_clocks"] += request["bursts"] * (spec.burst_beats // spec.clock_beats)
        channel["data_end"] = clock + spec.timing.n_cl
        channel["data_beats"] = (clock + spec.timing.n_cl) * spec.clock_beats
        requester = min(request["requester"], NO_REQUESTER)
        served_at(state, number, clock)
        channel["waited_clocks"] += clock - request["clock"]
        if request["is_write"] != 0:
            channel["writes"] += 1
        else:
            channel["reads"] += 1
            channel["read_bus_clocks"] += spec.timing.n_cl
        drop_oldest(state.queue, number)
    if num_items(state.queue, number) == 0:
        return requester, NEVER
    return requester, max(clock, oldest(state.queue, number)["clock"])


@inlined_step
def answer_cycle(spec, state, number, core_period_ticks):
    """The first core cycle at or after the data of the request that the channel answered last."""
    ticks = state.channels[number]["data_beats"] * spec.period_ticks
    cycle_ticks = core_period_ticks * spec.clock_beats
    return (ticks + cycle_ticks - 1) // cycle_ticks
