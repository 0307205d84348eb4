"""Channels of a DRAM with banks, rows, buses, refresh and FR-FCFS scheduling, compiled.

A channel is woken only at memory clocks at which something can happen. Waking it too early does no harm.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.model.dram.spec import DramSpec, Scheduler
from archsim.model.fifo.compiled import NEVER, QueueState, insert, new_queues, remove, slot_of

CLOSED = -1  # no row is open
NO_REQUESTER = 0  # fetches have numbers below 0
_ROW_HIT, _ROW_MISS, _ROW_CONFLICT = range(3)  # columns of `rows`

_FIELDS = ("arrival", "rank", "bank", "row", "bursts", "is_write", "requester", "is_classified")
QUEUED = np.dtype([(name, np.int64) for name in _FIELDS])  # arrival in ticks, rank is the cache


class DramState(NamedTuple):
    """H channels, B banks. Times are memory clocks unless said otherwise."""

    queue: QueueState  # [H] requests that were sent
    open_row: np.ndarray  # [H, B] row in the row buffer, or CLOSED
    bank_read: np.ndarray  # [H, B] earliest RD
    bank_write: np.ndarray  # [H, B] earliest WR
    bank_act: np.ndarray  # [H, B] earliest ACT
    bank_pre: np.ndarray  # [H, B] earliest PRE
    channel_read: np.ndarray  # [H] earliest RD
    channel_write: np.ndarray  # [H] earliest WR
    channel_act: np.ndarray  # [H] earliest ACT
    last_burst: np.ndarray  # [H] column command of the last request's last burst
    next_refresh: np.ndarray  # [H] when a REF is due
    due: np.ndarray  # [H] next clock at which the channel must be woken
    next_due: np.ndarray  # [1] the first of them
    window: np.ndarray  # [H] requests that have arrived, at most num_queue_entries
    wanted: np.ndarray  # [H, B] last wake-up at which a considered request wanted the open row
    seen: np.ndarray  # [H, B] last wake-up at which the bank's oldest considered request was looked at
    wake_ups: np.ndarray  # [H] number of them
    served: np.ndarray  # [H, 2] reads, writes
    rows: np.ndarray  # [H, 3] requests by row hit, miss, conflict
    activates: np.ndarray  # [H]
    precharges: np.ndarray  # [H]
    refreshes: np.ndarray  # [H]
    data_clocks: np.ndarray  # [H]


def new_dram(spec: DramSpec, queue_capacity: int) -> DramState:
    """All banks closed, all queues empty."""
    channels, banks = spec.num_channels, spec.num_banks
    refresh = spec.timing.n_refi if spec.timing.n_refi > 0 else NEVER

    def table(*shape: int, value: int = 0) -> np.ndarray:
        return np.full((channels, *shape), value, np.int64)

    return DramState(
        queue=new_queues(channels, queue_capacity, QUEUED),
        open_row=table(banks, value=CLOSED),
        bank_read=table(banks),
        bank_write=table(banks),
        bank_act=table(banks),
        bank_pre=table(banks),
        channel_read=table(),
        channel_write=table(),
        channel_act=table(),
        last_burst=table(value=-1),
        next_refresh=table(value=refresh),
        due=table(value=refresh),
        next_due=np.full(1, refresh, np.int64),
        window=table(),
        wanted=table(banks, value=-1),
        seen=table(banks, value=-1),
        wake_ups=table(),
        served=table(2),
        rows=table(3),
        activates=table(),
        precharges=table(),
        refreshes=table(),
        data_clocks=table(),
    )


@njit(forceinline=True)
def field_of(address, field):
    """The bit field of an address."""
    return (address >> field.shift) & ((1 << field.bits) - 1)


@njit(forceinline=True)
def _clock_of(spec, ticks):
    """First memory clock at or after a tick."""
    return (ticks + spec.period_ticks - 1) // spec.period_ticks


@njit
def send(spec, state, arrival_ticks, address, rank):
    """Queue a request for `address` that arrives at `arrival_ticks`; returns it, for the sender to say what it is."""
    channel = field_of(address, spec.channel)
    slot = insert(state.queue, channel, arrival_ticks, rank)
    request = state.queue.items[channel, slot]
    request["bank"] = field_of(address, spec.bank)
    request["row"] = field_of(address, spec.row)
    request["is_classified"] = 0
    state.due[channel] = min(state.due[channel], _clock_of(spec, arrival_ticks))
    state.next_due[0] = min(state.next_due[0], state.due[channel])
    return request


@njit
def is_empty(state):
    """Whether no request is queued or on its way to a queue."""
    for count in state.queue.count:
        if count > 0:
            return False
    return True


@njit
def first_due(state):
    """The channel that is due first, at clock `next_due`; of several the first."""
    channel = 0
    while state.due[channel] != state.next_due[0]:
        channel += 1
    return channel


@njit
def wake(spec, state, clock, channel):
    """Play memory clock `clock` of a channel and set when it is due again; returns the requester of a read served."""
    state.wake_ups[channel] += 1
    arrival = _classify_window(spec, state, clock, channel)
    requester = NO_REQUESTER
    if clock <= state.last_burst[channel] and (state.last_burst[channel] - clock) % spec.timing.n_ccd == 0:
        due = clock + 1
    elif clock >= state.next_refresh[channel]:
        due = _refresh(spec, state, clock, channel)
    else:
        num_considered, due = _num_considered(spec, state, clock, channel)
        position, column_due = _find_column(state, clock, channel, num_considered)
        if column_due <= clock:
            requester = _column(spec, state, clock, channel, position)
            due = clock + 1
        else:
            row_due = _row_command(spec, state, clock, channel, num_considered)
            due = min(min(due, state.next_refresh[channel]), min(column_due, row_due))
    state.due[channel] = min(due, arrival)
    state.next_due[0] = _earliest(state.due)
    return requester


@njit
def _earliest(times):
    """The least of some times."""
    least = NEVER
    for time in times:
        least = min(least, time)
    return least


@njit
def _classify_window(spec, state, clock, channel):
    """Classify what came into the window by `clock`; returns the clock of the next arrival in it, or NEVER."""
    size = min(state.queue.count[channel], spec.num_queue_entries)
    for position in range(size):
        request = state.queue.items[channel, slot_of(state.queue, channel, position)]
        if request["arrival"] > clock * spec.period_ticks:
            state.window[channel] = position
            return _clock_of(spec, request["arrival"])
        if request["is_classified"] == 0:
            request["is_classified"] = 1
            state.rows[channel, _row_outcome(state.open_row[channel, request["bank"]], request["row"])] += 1
    state.window[channel] = size
    return NEVER


@njit(forceinline=True)
def _row_outcome(open_row, row):
    """What a request finds in its bank."""
    if open_row == CLOSED:
        return _ROW_MISS
    return _ROW_HIT if open_row == row else _ROW_CONFLICT


@njit
def _refresh(spec, state, clock, channel):
    """One step towards the refresh that is due at `clock`: PRE of all banks, then REF. Returns when to go on."""
    timing = spec.timing
    is_open, pre_due, act_due = False, 0, 0
    for bank in range(spec.num_banks):
        act_due = max(act_due, state.bank_act[channel, bank])
        if state.open_row[channel, bank] != CLOSED:
            is_open = True
            pre_due = max(pre_due, state.bank_pre[channel, bank])
    due = pre_due if is_open else act_due
    if due > clock:
        return due

    if is_open:
        state.precharges[channel] += 1
    else:
        state.refreshes[channel] += 1
        state.next_refresh[channel] += timing.n_refi
    for bank in range(spec.num_banks):
        if state.open_row[channel, bank] != CLOSED:
            _bound(state.bank_act, channel, bank, clock + timing.n_rp)
            state.open_row[channel, bank] = CLOSED
        elif not is_open:
            _bound(state.bank_act, channel, bank, clock + timing.n_rfc)
    return clock + 1


@njit(forceinline=True)
def _bound(ready, channel, bank, clock):
    """The bank's command may not come before `clock`."""
    ready[channel, bank] = max(ready[channel, bank], clock)


@njit
def _num_considered(spec, state, clock, channel):
    """How many of the oldest requests the scheduler looks at in `clock`, and when that number changes by itself."""
    window = state.window[channel]
    if window == 0:
        return 0, NEVER
    if spec.scheduler == Scheduler.FCFS:
        return 1, NEVER

    oldest = state.queue.items[channel, state.queue.head[channel]]
    patience_ends = _clock_of(spec, oldest["arrival"]) + spec.max_wait_clocks + 1
    if clock >= patience_ends:
        return 1, NEVER
    return window, patience_ends


@njit
def _find_column(state, clock, channel, num_considered):
    """Position of the first request whose column command may issue in `clock` and that clock, else when one may."""
    due = NEVER
    for position in range(num_considered):
        request = state.queue.items[channel, slot_of(state.queue, channel, position)]
        bank = request["bank"]
        if state.open_row[channel, bank] != request["row"]:
            continue
        state.wanted[channel, bank] = state.wake_ups[channel]
        if request["is_write"] != 0:
            ready = max(state.bank_write[channel, bank], state.channel_write[channel])
        else:
            ready = max(state.bank_read[channel, bank], state.channel_read[channel])
        if ready <= clock:
            return position, clock
        due = min(due, ready)
    return num_considered, due


@njit
def _column(spec, state, clock, channel, position):
    """RD or WR of all bursts of the request from `clock` on; it leaves the queue. Returns a read's requester."""
    timing = spec.timing
    request = state.queue.items[channel, slot_of(state.queue, channel, position)]
    bank, bursts, is_write, requester = request["bank"], request["bursts"], request["is_write"], request["requester"]
    last = clock + (bursts - 1) * timing.n_ccd
    free = clock + bursts * timing.n_ccd
    if is_write != 0:
        written = last + timing.n_wl + spec.burst_beats // 2
        state.channel_write[channel] = max(state.channel_write[channel], free)
        state.channel_read[channel] = max(state.channel_read[channel], written + timing.n_wtr)
        _bound(state.bank_pre, channel, bank, written + timing.n_wr)
        requester = NO_REQUESTER
    else:
        state.channel_read[channel] = max(state.channel_read[channel], free)
        state.channel_write[channel] = max(state.channel_write[channel], last + timing.n_rtw)
        _bound(state.bank_pre, channel, bank, last + timing.n_rtp)

    state.last_burst[channel] = last
    state.served[channel, is_write] += 1
    state.data_clocks[channel] += bursts * (spec.burst_beats // 2)
    remove(state.queue, channel, position)
    return requester


@njit
def _row_command(spec, state, clock, channel, num_considered):
    """ACT or PRE in `clock` for the first request that can have it; returns when to look again."""
    due = NEVER
    wake_up = state.wake_ups[channel]
    for position in range(num_considered):
        request = state.queue.items[channel, slot_of(state.queue, channel, position)]
        bank = request["bank"]
        if state.seen[channel, bank] == wake_up or state.wanted[channel, bank] == wake_up:
            continue
        state.seen[channel, bank] = wake_up
        is_closed = state.open_row[channel, bank] == CLOSED
        if is_closed:
            ready = max(state.bank_act[channel, bank], state.channel_act[channel])
        else:
            ready = state.bank_pre[channel, bank]
        if ready <= clock:
            if is_closed:
                _activate(spec.timing, state, clock, channel, request)
            else:
                _precharge(spec.timing, state, clock, channel, bank)
            return clock + 1
        due = min(due, ready)
    return due


@njit
def _activate(timing, state, clock, channel, request):
    """ACT in `clock` of the request's row."""
    bank = request["bank"]
    state.open_row[channel, bank] = request["row"]
    state.activates[channel] += 1
    _bound(state.bank_read, channel, bank, clock + timing.n_rcd_read)
    _bound(state.bank_write, channel, bank, clock + timing.n_rcd_write)
    _bound(state.bank_pre, channel, bank, clock + timing.n_ras)
    _bound(state.bank_act, channel, bank, clock + timing.n_rc)
    state.channel_act[channel] = max(state.channel_act[channel], clock + timing.n_rrd)


@njit
def _precharge(timing, state, clock, channel, bank):
    """PRE in `clock` of one bank."""
    state.open_row[channel, bank] = CLOSED
    state.precharges[channel] += 1
    _bound(state.bank_act, channel, bank, clock + timing.n_rp)


@njit(forceinline=True)
def data_half_ticks(spec, state, channel):
    """Twice the tick of the last beat of the read served last, so that half ticks are exact."""
    return (2 * (state.last_burst[channel] + spec.timing.n_cl) + spec.burst_beats - 1) * spec.period_ticks
