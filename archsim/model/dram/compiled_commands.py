"""What the commands of the compiled DRAM set: bounds, which only rise; lists of hits; counters; the record."""

from __future__ import annotations

import numpy as np

from archsim.model.compiled import inlined_step, step
from archsim.model.dram.commands import Command
from archsim.model.dram.compiled_state import (
    BANK_BITS,
    CLOSED,
    KEY_SHIFT,
    NO_KEY,
    NO_REQUESTER,
    NO_WISH,
    NOBODY,
    READS,
    ROW_BIT,
    TO_ACT,
    TO_PRE,
    TO_READ,
    TO_WRITE,
    WRITES,
)
from archsim.model.dram.compiled_waits import charge_read, find_wait

_ACT, _PRE, _PREA = int(Command.ACT), int(Command.PRE), int(Command.PREA)
_RD, _WR, _REF = int(Command.RD), int(Command.WR), int(Command.REF)


@inlined_step
def field_of(address, field):
    """The bit field of an address."""
    return (address >> field.shift) & ((1 << field.bits) - 1)


@inlined_step
def place_of(state, told, bank_number):
    """Where the bank's bound and wish for what it may be told are among its channel's."""
    return np.uint32(told * state.banks.shape[1] + np.int64(bank_number))


@inlined_step
def raise_to(bounds, place, clock):
    """A bound that is a running maximum."""
    bounds[place] = max(bounds[place], clock)


@inlined_step
def _keep_from_act(state, number, bank_number, clock):
    """The bank itself is not ready for an ACT before `clock`."""
    raise_to(state.banks[number, bank_number], "act_ready", clock)
    raise_to(state.bounds[number], place_of(state, TO_ACT, bank_number), clock)


@inlined_step
def _raise_all(state, number, told, clock):
    """No bank of the channel may be told so before `clock`."""
    first = place_of(state, told, 0)
    for place in range(first, first + state.banks.shape[1]):
        state.bounds[number, place] = max(state.bounds[number, place], clock)


@inlined_step
def note_wishes(state, number, bank_number):
    """Find out which requests come first for what the bank may be told: hits, or else the row of the oldest."""
    kinds, wishes = state.channels[number]["kinds"], state.wishes[number]
    lists = state.lists[number, bank_number]
    read_hit, read_first = lists[READS]["hit_key"], lists[READS]["first_key"]
    write_hit, write_first = lists[WRITES]["hit_key"], lists[WRITES]["first_key"]
    if kinds >> READS & 1 == 0:
        read_hit = read_first = NO_KEY
    if kinds >> WRITES & 1 == 0:
        write_hit = write_first = NO_KEY
    row = min(_wish(read_first, READS, bank_number), _wish(write_first, WRITES, bank_number))
    row = row | ROW_BIT if min(read_hit, write_hit) == NO_KEY and row != NO_WISH else NO_WISH
    is_closed = state.banks[number, bank_number]["open_row"] == CLOSED
    wishes[place_of(state, TO_READ, bank_number)] = _wish(read_hit, READS, bank_number)
    wishes[place_of(state, TO_WRITE, bank_number)] = _wish(write_hit, WRITES, bank_number)
    wishes[place_of(state, TO_ACT, bank_number)] = row if is_closed else NO_WISH
    wishes[place_of(state, TO_PRE, bank_number)] = NO_WISH if is_closed else row


@inlined_step
def _wish(key, kind, bank_number):
    """The wish of the request with this key."""
    return NO_WISH if key == NO_KEY else key << KEY_SHIFT | kind << BANK_BITS | np.int64(bank_number)


@inlined_step
def activate(spec, state, clock, number, bank_number, row):
    """ACT in `clock`."""
    timing, channel, bank = spec.timing, state.channels[number], state.banks[number, bank_number]
    channel["activates"] += 1
    bank["open_row"], bank["last_use"], bank["opened"] = row, clock, clock
    bounds, next_act = state.bounds[number], clock + timing.n_rrd
    raise_to(bounds, place_of(state, TO_READ, bank_number), clock + timing.n_rcd_read)
    raise_to(bounds, place_of(state, TO_WRITE, bank_number), clock + timing.n_rcd_write)
    raise_to(bounds, place_of(state, TO_PRE, bank_number), clock + timing.n_ras)
    _keep_from_act(state, number, bank_number, clock + timing.n_rc)
    if spec.num_groups > 1:
        for other in range(bank_number % spec.num_groups, spec.num_banks, spec.num_groups):
            _keep_from_act(state, number, other, clock + timing.n_rrd_l)
    if timing.n_faw > 0:
        next_act = max(next_act, _first_of_window(state.activates[number], clock) + timing.n_faw)
    _raise_all(state, number, TO_ACT, next_act)

    for kind in range(2):
        requests = state.lists[number, bank_number, kind]
        _set_hit(state, number, requests, next_hit(state, number, requests["first"], row))
    note_wishes(state, number, bank_number)
    log(state, clock, number, _ACT, bank_number, row, 0, 0)


@inlined_step
def _first_of_window(activates, clock):
    """Note an ACT in `clock`; returns the clock of the first of the last four."""
    for i in range(len(activates) - 1):
        activates[i] = activates[i + 1]
    activates[len(activates) - 1] = clock
    return activates[0]


@inlined_step
def _set_hit(state, number, requests, slot):
    """Note the first request of a list that wants the open row."""
    requests["hit"] = slot
    requests["hit_key"] = state.waiting[number, slot]["number"]


@inlined_step
def next_hit(state, number, slot, row):
    """The first request from `slot` on in its list that wants the row."""
    while slot != NOBODY and state.waiting[number, slot]["row"] != row:
        slot = state.waiting[number, slot]["next"]
    return slot


@inlined_step
def precharge(spec, state, clock, number, bank_number):
    """PRE in `clock`."""
    row = state.banks[number, bank_number]["open_row"]
    state.channels[number]["precharges"] += 1
    _close(spec, state, clock, number, bank_number)
    log(state, clock, number, _PRE, bank_number, row, 0, 0)


@inlined_step
def _close(spec, state, clock, number, bank_number):
    """Close a bank in `clock`: nobody's row is open then."""
    bank = state.banks[number, bank_number]
    bank["open_row"], bank["closed"] = CLOSED, clock
    _keep_from_act(state, number, bank_number, clock + spec.timing.n_rp)
    for kind in range(2):
        _set_hit(state, number, state.lists[number, bank_number, kind], NOBODY)
    note_wishes(state, number, bank_number)


@step
def refresh_due(state, number):
    """The clock in which the next step of a refresh may be done: PRE of all open banks, or REF."""
    is_open, pre_due, act_due = False, 0, 0
    for bank_number in range(state.banks.shape[1]):
        act_due = max(act_due, state.banks[number, bank_number]["act_ready"])
        if state.banks[number, bank_number]["open_row"] != CLOSED:
            is_open = True
            pre_due = max(pre_due, state.bounds[number, place_of(state, TO_PRE, bank_number)])
    return pre_due if is_open else act_due


@step
def refresh(spec, state, clock, number):
    """The next step of a refresh: PRE of all open banks in `clock`, or REF if there are none."""
    channel, is_open = state.channels[number], False
    for bank_number in range(spec.num_banks):
        if state.banks[number, bank_number]["open_row"] != CLOSED:
            is_open = True
            _close(spec, state, clock, number, bank_number)
    if is_open:
        channel["precharges"] += 1
        log(state, clock, number, _PREA, 0, 0, 0, 0)
        return

    channel["refreshes"] += 1
    channel["refresh_began"], channel["refresh_ended"] = channel["next_refresh"], clock + spec.timing.n_rfc
    channel["next_refresh"] += spec.timing.n_refi
    for bank_number in range(spec.num_banks):
        _keep_from_act(state, number, bank_number, clock + spec.timing.n_rfc)
    log(state, clock, number, _REF, 0, 0, 0, 0)


@step
def _column_of(spec, address):
    """Bursts of the row that lie before the address."""
    offset_bits = spec.row.shift
    for field in (spec.channel, spec.group, spec.bank, spec.line):
        offset_bits = min(offset_bits, field.shift) if field.bits > 0 else offset_bits
    place = (field_of(address, spec.line) << offset_bits) + (address & ((1 << offset_bits) - 1))
    return place // (spec.burst_beats * spec.beat_bytes)


@inlined_step
def column(spec, state, clock, number, slot):
    """RD or WR of all bursts of the request from `clock` on; it leaves its window. Returns who is answered."""
    timing, channel, request = spec.timing, state.channels[number], state.waiting[number, slot]
    bank, is_write, bursts = state.banks[number, request["bank"]], request["is_write"], request["bursts"]
    bounds = state.bounds[number]
    last = clock + (bursts - 1) * timing.n_ccd_l
    find_wait(spec, state, number, slot, clock)
    channel["waited_clocks"] += clock - request["clock"]
    channel["last_burst"] = bank["last_use"] = last
    channel["data_clocks"] += bursts * (spec.burst_beats // spec.clock_beats)
    next_read = next_write = last + timing.n_ccd
    read_in_group = last + timing.n_ccd_l
    if is_write != 0:
        written = last + timing.n_wl + spec.burst_beats // spec.clock_beats
        channel["written"], channel["written_bank"] = written, request["bank"]
        raise_to(channel, "data_end", written)
        channel["writes"] += 1
        channel["data_beats"] = (last + timing.n_wl) * spec.clock_beats + spec.burst_beats - 1
        next_read = max(next_read, written + timing.n_wtr)
        raise_to(bounds, place_of(state, TO_PRE, request["bank"]), written + timing.n_wr)
        read_in_group = max(read_in_group, written + timing.n_wtr_l)
    else:
        channel["reads"] += 1
        charge_read(spec, state, number, request["clock"], last)
        channel["last_read"] = last
        channel["data_beats"] = (last + timing.n_cl) * spec.clock_beats + spec.burst_beats - 1
        raise_to(channel, "data_end", last + timing.n_cl + spec.burst_beats // spec.clock_beats)
        next_write = max(next_write, last + timing.n_rtw)
        raise_to(bounds, place_of(state, TO_PRE, request["bank"]), last + timing.n_rtp)
    _raise_all(state, number, TO_READ, next_read)
    _raise_all(state, number, TO_WRITE, next_write)
    if spec.num_groups > 1:
        for other in range(request["bank"] % spec.num_groups, spec.num_banks, spec.num_groups):
            raise_to(bounds, place_of(state, TO_READ, other), read_in_group)
            raise_to(bounds, place_of(state, TO_WRITE, other), last + timing.n_ccd_l)

    if len(state.log) > 0:
        column_number = _column_of(spec, request["address"])
        command = _WR if is_write != 0 else _RD
        log(state, clock, number, command, request["bank"], request["row"], column_number, bursts)
    _leave(spec, state, number, slot)
    return min(request["requester"], NO_REQUESTER)


@inlined_step
def _leave(spec, state, number, slot):
    """Take the request, which wants the open row, out of its list and window."""
    channel, request = state.channels[number], state.waiting[number, slot]
    requests = state.lists[number, request["bank"], request["is_write"]]
    _set_hit(state, number, requests, next_hit(state, number, request["next"], request["row"]))
    before = NOBODY
    if requests["first"] == slot:
        requests["first"] = request["next"]
        requests["first_key"] = state.waiting[number, request["next"]]["number"]
    else:
        before = requests["first"]
        while state.waiting[number, before]["next"] != slot:
            before = state.waiting[number, before]["next"]
        state.waiting[number, before]["next"] = request["next"]
    if requests["last"] == slot:
        requests["last"] = before
    note_wishes(state, number, request["bank"])

    request["next"] = channel["free"]
    channel["free"] = slot
    if request["is_write"] == WRITES:
        channel["num_writes"] -= 1
    else:
        channel["num_reads"] -= 1


@inlined_step
def log(state, clock, number, command, bank_number, row, column_number, bursts):
    """Record a command if commands are recorded."""
    if len(state.log) == 0:
        return
    if state.log_size[0] == len(state.log):
        state.log_size[1] += 1
        return
    entry = state.log[state.log_size[0]]
    entry["clock"], entry["channel"], entry["command"] = clock, number, command
    entry["bank"], entry["row"], entry["column"], entry["bursts"] = bank_number, row, column_number, bursts
    state.log_size[0] += 1
