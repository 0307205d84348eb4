"""Channels of a DRAM with banks, rows, buses, refresh and FR-FCFS scheduling, compiled.

A channel is woken only at memory clocks at which something can happen. Waking it too early does no harm.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.model.compiled import (
    NEVER,
    QueueState,
    inlined_step,
    insert,
    new_queues,
    num_items,
    oldest,
    record,
    remove,
    slot_of,
    step,
)
from archsim.model.dram.spec import DramSpec, Scheduler

CLOSED = -1  # no row is open
NO_REQUESTER = 0  # fetches have numbers below 0

_BANK_FIELDS = (
    "open_row",  # row in the row buffer, or CLOSED
    "read",  # earliest RD
    "write",  # earliest WR
    "act",  # earliest ACT
    "pre",  # earliest PRE
    "wanted",  # last wake-up at which a considered request wanted the open row
    "seen",  # last wake-up at which the bank's oldest considered request was looked at
)
_CHANNEL_FIELDS = (
    "read",  # earliest RD
    "write",  # earliest WR
    "act",  # earliest ACT
    "last_burst",  # column command of the last request's last burst
    "next_refresh",  # when a REF is due
    "wake_ups",  # number of them
)
DRAM_COUNTERS = (
    "reads",
    "writes",
    "row_hits",
    "row_misses",
    "row_conflicts",
    "activates",
    "precharges",
    "refreshes",
    "data_clocks",
)
_QUEUED_FIELDS = (
    "arrival",  # tick
    "clock",  # first at or after it
    "rank",  # cache that sent the request
    "row",
    "requester",
)
QUEUED = record(*_QUEUED_FIELDS, indices=("bank", "bursts", "is_write"))
BANK = record(*_BANK_FIELDS)
CHANNEL = record(*_CHANNEL_FIELDS, *DRAM_COUNTERS, indices=("window",))  # requests that the scheduler sees


class DramState(NamedTuple):
    """H channels, B banks. Times are memory clocks unless said otherwise."""

    queue: QueueState  # QUEUED [H] requests that were sent
    banks: np.ndarray  # BANK [H, B]
    channels: np.ndarray  # CHANNEL [H]
    due: np.ndarray  # [H] next clock at which the channel must be woken
    next_due: np.ndarray  # [2] the first of them and its channel


def new_dram(spec: DramSpec, queue_capacity: int) -> DramState:
    """All banks closed, all queues empty."""
    refresh = spec.timing.n_refi if spec.timing.n_refi > 0 else NEVER
    banks = np.zeros((spec.num_channels, spec.num_banks), BANK)
    banks["open_row"] = CLOSED
    channels = np.zeros(spec.num_channels, CHANNEL)
    channels["last_burst"] = -1
    channels["next_refresh"] = refresh
    queue = new_queues(spec.num_channels, queue_capacity, QUEUED)
    due = np.full(spec.num_channels, refresh)
    return DramState(queue, banks, channels, due, np.array([refresh, 0], np.int64))


@inlined_step
def field_of(address, field):
    """The bit field of an address."""
    return (address >> field.shift) & ((1 << field.bits) - 1)


@step
def send(spec, state, arrival_ticks, address, rank):
    """Queue a request for `address` that arrives at `arrival_ticks`; returns it, for the sender to say what it is."""
    number = field_of(address, spec.channel)
    slot = insert(state.queue, number, arrival_ticks, rank)
    request = state.queue.items[number, slot]
    request["bank"] = field_of(address, spec.bank)
    request["row"] = field_of(address, spec.row)
    request["clock"] = (arrival_ticks + spec.period_ticks - 1) // spec.period_ticks
    state.due[number] = min(state.due[number], request["clock"])
    if state.due[number] < state.next_due[0]:
        state.next_due[0] = state.due[number]
        state.next_due[1] = number
    return request


@step
def is_empty(state):
    """Whether no request is queued or on its way to a queue."""
    for number in range(len(state.channels)):
        if num_items(state.queue, number) > 0:
            return False
    return True


@inlined_step
def wake_first(spec, state):
    """Play the clock `next_due` of the channel that is due; returns the requester of a read served."""
    clock, number = state.next_due[0], state.next_due[1]
    channel = state.channels[number]
    channel["wake_ups"] += 1
    arrival = _classify_arrived(spec, state, clock, number)
    requester = NO_REQUESTER
    if _needs_bus(spec.timing, channel, clock):
        due = clock + 1
    elif clock >= channel["next_refresh"]:
        due = _refresh(spec.timing, channel, state.banks[number], clock)
    else:
        num_considered, due = _num_considered(spec, state, clock, number)
        due = min(due, channel["next_refresh"])
        position, others, command_due = _find_column(state, clock, number, num_considered)
        if position < num_considered:
            requester = _column(spec, state, clock, number, position)
        elif others > 0:
            command_due = min(command_due, _row_command(spec.timing, state, clock, number, num_considered))
        if command_due <= clock:  # there was a command
            command_due = _look_again(state, clock, number)
        due = min(due, command_due)
    due = min(due, arrival)
    state.due[number] = due + 1 if _needs_bus(spec.timing, channel, due) else due
    _find_next_due(state)
    return requester


@inlined_step
def _needs_bus(timing, channel, clock):
    """Whether a burst of the last request still needs the command bus at `clock`."""
    return clock <= channel["last_burst"] and (channel["last_burst"] - clock) % timing.n_ccd == 0


@step
def _find_next_due(state):
    """Find out which channel is due first; of several the first."""
    first = 0
    for number in range(1, len(state.due)):
        first = number if state.due[number] < state.due[first] else first
    state.next_due[0] = state.due[first]
    state.next_due[1] = first


@step
def _classify_arrived(spec, state, clock, number):
    """Classify what came into the window by `clock`; returns the clock of the next arrival in it, or NEVER.

    A request can wait for this until its channel wakes: until then, no row is opened or closed.
    """
    channel = state.channels[number]
    size = min(num_items(state.queue, number), spec.num_queue_entries)
    while channel["window"] < size:
        request = state.queue.items[number, slot_of(state.queue, number, channel["window"])]
        if request["clock"] > clock:
            return request["clock"]
        _classify(channel, state.banks[number, request["bank"]]["open_row"], request["row"])
        channel["window"] += 1
    return NEVER


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
def _refresh(timing, channel, banks, clock):
    """One step towards the refresh that is due at `clock`: PRE of all banks, then REF. Returns when to go on."""
    is_open, pre_due, act_due = False, 0, 0
    for number in range(len(banks)):
        act_due = max(act_due, banks[number]["act"])
        if banks[number]["open_row"] != CLOSED:
            is_open = True
            pre_due = max(pre_due, banks[number]["pre"])
    due = pre_due if is_open else act_due
    if due > clock:
        return due

    if is_open:
        channel["precharges"] += 1
    else:
        channel["refreshes"] += 1
        channel["next_refresh"] += timing.n_refi
    for number in range(len(banks)):
        if banks[number]["open_row"] != CLOSED:
            banks[number]["act"] = max(banks[number]["act"], clock + timing.n_rp)
            banks[number]["open_row"] = CLOSED
        elif not is_open:
            banks[number]["act"] = max(banks[number]["act"], clock + timing.n_rfc)
    return clock + 1


@step
def _num_considered(spec, state, clock, number):
    """How many of the oldest requests the scheduler looks at in `clock`, and when that number changes by itself."""
    window = state.channels[number]["window"]
    if window == 0:
        return 0, NEVER
    if spec.scheduler == Scheduler.FCFS:
        return 1, NEVER

    patience_ends = oldest(state.queue, number)["clock"] + spec.max_wait_clocks + 1
    if clock >= patience_ends:
        return 1, NEVER
    return window, patience_ends


@step
def _find_column(state, clock, number, num_considered):
    """Position of the first request whose column command may issue in `clock`, else past the end.

    Also returns how many before it do not find their row open, and the first clock in which one may issue.
    """
    channel = state.channels[number]
    due, others = NEVER, 0
    for position in range(num_considered):
        request = state.queue.items[number, slot_of(state.queue, number, position)]
        bank = state.banks[number, request["bank"]]
        if bank["open_row"] != request["row"]:
            others += 1
            continue
        bank["wanted"] = channel["wake_ups"]
        ready = _column_ready(channel, bank, request)
        if ready <= clock:
            return position, others, clock
        due = min(due, ready)
    return num_considered, others, due


@inlined_step
def _column_ready(channel, bank, request):
    """First clock in which the request can have its RD or WR, its row being open."""
    if request["is_write"] != 0:
        return max(bank["write"], channel["write"])
    return max(bank["read"], channel["read"])


@step
def _column(spec, state, clock, number, position):
    """RD or WR of all bursts of the request from `clock` on; it leaves the queue. Returns a read's requester."""
    timing, channel = spec.timing, state.channels[number]
    request = state.queue.items[number, slot_of(state.queue, number, position)]
    bank = state.banks[number, request["bank"]]
    bursts, requester = request["bursts"], NO_REQUESTER
    last = clock + (bursts - 1) * timing.n_ccd
    if request["is_write"] != 0:
        written = last + timing.n_wl + spec.burst_beats // 2
        channel["writes"] += 1
        channel["write"] = max(channel["write"], clock + bursts * timing.n_ccd)
        channel["read"] = max(channel["read"], written + timing.n_wtr)
        bank["pre"] = max(bank["pre"], written + timing.n_wr)
    else:
        requester = request["requester"]
        channel["reads"] += 1
        channel["read"] = max(channel["read"], clock + bursts * timing.n_ccd)
        channel["write"] = max(channel["write"], last + timing.n_rtw)
        bank["pre"] = max(bank["pre"], last + timing.n_rtp)

    channel["last_burst"] = last
    channel["data_clocks"] += bursts * (spec.burst_beats // 2)
    channel["window"] -= 1
    remove(state.queue, number, position)
    return requester


@step
def _row_command(timing, state, clock, number, num_considered):
    """ACT or PRE in `clock` for the first request that can have it; returns `clock` then, else when to look again."""
    channel = state.channels[number]
    due, wake_up = NEVER, channel["wake_ups"]
    for position in range(num_considered):
        request = state.queue.items[number, slot_of(state.queue, number, position)]
        bank = state.banks[number, request["bank"]]
        if bank["seen"] == wake_up or bank["wanted"] == wake_up:
            continue
        bank["seen"] = wake_up
        is_closed = bank["open_row"] == CLOSED
        ready = max(bank["act"], channel["act"]) if is_closed else bank["pre"]
        if ready <= clock:
            if is_closed:
                _activate(timing, channel, bank, clock, request["row"])
            else:
                _precharge(timing, channel, bank, clock)
            return clock
        due = min(due, ready)
    return due


@step
def _look_again(state, clock, number):
    """When to look again after a command in `clock`: if a single request is left, when it can have its next command."""
    channel, num_queued = state.channels[number], num_items(state.queue, number)
    if num_queued == 0:
        return NEVER
    if num_queued > 1 or channel["window"] == 0:
        return clock + 1

    request = oldest(state.queue, number)
    bank = state.banks[number, request["bank"]]
    if bank["open_row"] == CLOSED:
        return max(clock + 1, max(bank["act"], channel["act"]))
    if bank["open_row"] == request["row"]:
        return max(clock + 1, _column_ready(channel, bank, request))
    return max(clock + 1, bank["pre"])


@step
def _activate(timing, channel, bank, clock, row):
    """ACT in `clock`."""
    channel["activates"] += 1
    bank["open_row"] = row
    bank["read"] = max(bank["read"], clock + timing.n_rcd_read)
    bank["write"] = max(bank["write"], clock + timing.n_rcd_write)
    bank["pre"] = max(bank["pre"], clock + timing.n_ras)
    bank["act"] = max(bank["act"], clock + timing.n_rc)
    channel["act"] = max(channel["act"], clock + timing.n_rrd)


@step
def _precharge(timing, channel, bank, clock):
    """PRE in `clock` of one bank."""
    channel["precharges"] += 1
    bank["open_row"] = CLOSED
    bank["act"] = max(bank["act"], clock + timing.n_rp)


@inlined_step
def data_half_ticks(spec, state, number):
    """Twice the tick of the last beat of the read served last, so that half ticks are exact."""
    return (
        2 * (state.channels[number]["last_burst"] + spec.timing.n_cl) + spec.burst_beats - 1
    ) * spec.period_ticks
