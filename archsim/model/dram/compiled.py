"""Channels of a DRAM with banks, rows, buses, refresh and schedulers, compiled.

A channel is woken only at memory clocks at which something can happen. Waking it too early does no harm.
"""

from __future__ import annotations

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
    "has_room",
    "is_empty",
    "is_log_half_full",
    "new_dram",
    "recording",
    "ring_of_request",
    "send",
    "take_log",
    "wake_first",
]

_IDEAL = int(Scheduler.IDEAL)
_CHANNEL_BITS = 12  # of a clock and a channel in one integer; a configuration has at most 4,096


@inlined_step
def ring_of_request(spec, address, is_write):
    """The ring of `queue` that a request joins."""
    return ring_of(spec, field_of(address, spec.channel), is_write)


@inlined_step
def send(spec, state, arrival_ticks, address, rank, is_write):
    """Queue a request that arrives at `arrival_ticks`; returns it, for the sender to give its bursts and requester."""
    number = field_of(address, spec.channel)
    ring = ring_of(spec, number, is_write)
    slot = insert(state.queue, ring, arrival_ticks, rank)
    request = state.queue.items[ring, slot]
    request["address"] = address
    request["is_write"] = is_write
    request["clock"] = (arrival_ticks + spec.period_ticks - 1) // spec.period_ticks
    request["order"] = state.channels[number]["sent"]
    state.channels[number]["sent"] += 1
    state.due[number] = min(state.due[number], request["clock"])
    if state.due[number] < state.next_due[0]:
        state.next_due[0] = state.due[number]
        state.next_due[1] = number
    return request


@step
def is_empty(state):
    """Whether no request is queued or on its way to a queue."""
    for ring in range(len(state.queue.ends)):
        if num_items(state.queue, ring) > 0:
            return False
    for number in range(len(state.channels)):
        if state.channels[number]["num_reads"] > 0 or state.channels[number]["num_writes"] > 0:
            return False
    return True


@inlined_step
def has_room(spec, state, address, is_write):
    """Whether a request that came now would enter its window at once."""
    number = field_of(address, spec.channel)
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
    sink(state.log[:recorded].copy())
    state.log_size[0] = 0


@inlined_step
def wake_first(spec, state):
    """Play the clock `next_due` of the channel that is due; returns who is answered, or NO_REQUESTER."""
    clock, number = state.next_due[0], state.next_due[1]
    if spec.scheduler == _IDEAL:
        requester = _serve_first(spec, state, clock, number)
    else:
        requester = _wake(spec, state, clock, number)
    _find_next_due(state)
    return requester


@inlined_step
def _wake(spec, state, clock, number):
    """Play `clock`: entries, then the command that is planned. Stops at a read answered without a command."""
    channel = state.channels[number]
    if spec.num_write_entries > 0 and clock > channel["last_wake"] + 1:
        channel["is_draining"] = drains(spec, channel)  # as it was decided in the clocks between
    channel["last_wake"] = clock
    requester = enter(spec, state, clock, number)
    if requester != NO_REQUESTER:
        channel["plan"] = PLAN_AGAIN
        channel["plan_due"] = state.due[number] = clock
        return requester

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
    state.due[number] = min(channel["plan_due"], max(clock + 1, entry))
    return requester


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
    """IDEAL: serve the oldest request, as if its row were open; returns who is answered."""
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
    state.due[number] = NEVER
    if num_items(state.queue, number) > 0:
        state.due[number] = max(clock, oldest(state.queue, number)["clock"])
    return requester


@inlined_step
def _find_next_due(state):
    """Find out which channel is due first; of several the first: the least of clock, then channel, in one integer."""
    first = NEVER << _CHANNEL_BITS
    for number in range(len(state.due)):
        first = min(first, (state.due[number] << _CHANNEL_BITS) + number)
    state.next_due[0], state.next_due[1] = first >> _CHANNEL_BITS, first & ((1 << _CHANNEL_BITS) - 1)


@inlined_step
def answer_cycle(spec, state, number, core_period_ticks):
    """The first core cycle at or after the data of the request that the channel answered last."""
    ticks = state.channels[number]["data_beats"] * spec.period_ticks
    cycle_ticks = core_period_ticks * spec.clock_beats
    return (ticks + cycle_ticks - 1) // cycle_ticks
