"""What a channel of the compiled DRAM does next, and when: the scheduler and the page policy.

A plan holds until a request enters a window or a command issues. Each candidate for a command has the clock in which
it may issue first; the earliest is planned, and of several the one with the smallest key.
"""

from __future__ import annotations

from archsim.model.compiled import NEVER, inlined_step, step
from archsim.model.dram.compiled_commands import refresh_due
from archsim.model.dram.compiled_state import (
    CLOSE,
    CLOSED,
    COLUMN,
    NOBODY,
    PLAN_AGAIN,
    REFRESH,
    ROW,
    WRITES,
)
from archsim.model.dram.spec import PagePolicy, Scheduler

_OPEN_PAGE, _TIMEOUT, _FCFS = int(PagePolicy.OPEN), int(PagePolicy.TIMEOUT), int(Scheduler.FCFS)
_ROW_KEY, _LAST_KEY = 1 << 60, 1 << 61  # column commands first, by age, then row commands by age


@inlined_step
def drains(spec, channel):
    """Whether writes are to be served: from the high mark down to the low one, or while no read waits."""
    if channel["num_writes"] == 0:
        return 0
    if channel["num_reads"] == 0:
        return 1
    if channel["is_draining"] != 0:
        return 1 if channel["num_writes"] > spec.write_low else 0
    return 1 if channel["num_writes"] >= spec.write_high else 0


@step
def plan(spec, state, clock, number):
    """Find out what the channel does next from `clock` on, if nobody enters before."""
    channel = state.channels[number]
    while needs_bus(spec.timing, channel, clock):
        clock += 1
    command, due = PLAN_AGAIN, NEVER
    if clock >= channel["next_refresh"]:
        command, due = REFRESH, max(clock, refresh_due(state, number))
    else:
        if channel["num_reads"] + channel["num_writes"] > 0 or spec.page_policy != _OPEN_PAGE:
            command, due = _command(spec, state, clock, number)
        if due >= channel["next_refresh"]:
            command, due = PLAN_AGAIN, channel["next_refresh"]
    if needs_bus(spec.timing, channel, due):
        command, due = PLAN_AGAIN, due + 1
    channel["plan"], channel["plan_due"] = command, due


@inlined_step
def needs_bus(timing, channel, clock):
    """Whether a burst of the last request still needs the command bus at `clock`."""
    return clock <= channel["last_burst"] and (channel["last_burst"] - clock) % timing.n_ccd_l == 0


@inlined_step
def _command(spec, state, clock, number):
    """The first command that may issue from `clock` on, and when; its bank and request are noted."""
    first_kind, end_kind, draining = 0, 2, 0
    if spec.num_write_entries > 0:
        draining = drains(spec, state.channels[number])
        first_kind, end_kind = draining, draining + 1

    only = NOBODY
    if spec.scheduler == _FCFS:
        only = _oldest(state, number, first_kind, end_kind)
    elif draining == 0:
        only = _out_of_patience(spec, state, clock, number, first_kind, end_kind)
    if only != NOBODY:
        command, due = _of_one(state, clock, number, only)
    else:
        command, due = _of_all(state, clock, number, first_kind, end_kind)
        patience_ends = state.channels[number]["patience_ends"]
        if spec.scheduler != _FCFS and draining == 0 and patience_ends <= due < NEVER:
            command, due = PLAN_AGAIN, patience_ends
    if spec.page_policy != _OPEN_PAGE:
        command, due = _or_close(spec, state, clock, number, only, (first_kind, end_kind), (command, due))
    return command, due


@step
def _oldest(state, number, first_kind, end_kind):
    """The request that entered first, or NOBODY."""
    oldest = NOBODY
    for bank_number in range(state.banks.shape[1]):
        for kind in range(first_kind, end_kind):
            first = state.lists[number, bank_number, kind]["first"]
            if first != NOBODY and (
                oldest == NOBODY
                or state.waiting[number, first]["number"] < state.waiting[number, oldest]["number"]
            ):
                oldest = first
    return oldest


@inlined_step
def _out_of_patience(spec, state, clock, number, first_kind, end_kind):
    """The oldest request if it has waited for too long in `clock`, or NOBODY.

    `patience_ends` need not be exact: the oldest only gets younger, so that it comes too early at worst.
    """
    channel = state.channels[number]
    if clock < channel["patience_ends"]:
        return NOBODY
    oldest = _oldest(state, number, first_kind, end_kind)
    if oldest == NOBODY:
        return NOBODY
    ends = state.waiting[number, oldest]["clock"] + spec.max_wait_clocks + 1
    if clock < ends:
        channel["patience_ends"] = ends
        return NOBODY
    return oldest


@inlined_step
def _of_one(state, clock, number, slot):
    """The command that this request needs, and from `clock` on when it may issue."""
    channel, request = state.channels[number], state.waiting[number, slot]
    bank = state.banks[number, request["bank"]]
    channel["plan_bank"], channel["plan_slot"] = request["bank"], slot
    if bank["open_row"] == request["row"]:
        return COLUMN, max(clock, _column_due(channel, bank, request["is_write"]))
    return ROW, max(clock, _row_due(channel, bank))


@inlined_step
def _column_due(channel, bank, kind):
    """The first clock for the RD or WR of the open row."""
    if kind == WRITES:
        return max(bank["write"], channel["write"])
    return max(bank["read"], channel["read"])


@inlined_step
def _row_due(channel, bank):
    """The first clock for the ACT of a closed bank, or the PRE of an open one."""
    return max(bank["act"], channel["act"]) if bank["open_row"] == CLOSED else bank["pre"]


@step
def _of_all(state, clock, number, first_kind, end_kind):
    """The first command from `clock` on that any waiting request may have, and when."""
    channel = state.channels[number]
    best_due, best_key, command, best_bank, best_slot = NEVER, 0, PLAN_AGAIN, 0, NOBODY
    for bank_number in range(state.banks.shape[1]):
        bank, oldest, oldest_key, is_wanted = state.banks[number, bank_number], NOBODY, _LAST_KEY, False
        for kind in range(first_kind, end_kind):
            requests = state.lists[number, bank_number, kind]
            slot = requests["hit"]
            if slot != NOBODY:
                is_wanted = True
                due = max(clock, _column_due(channel, bank, kind))
                if due <= best_due:
                    key = state.waiting[number, slot]["number"]
                    if due < best_due or key < best_key:
                        best_due, best_key, command = due, key, COLUMN
                        best_bank, best_slot = bank_number, int(slot)
            elif requests["first"] != NOBODY:
                key = _ROW_KEY + state.waiting[number, requests["first"]]["number"]
                if key < oldest_key:
                    oldest, oldest_key = int(requests["first"]), key
        if oldest != NOBODY and not is_wanted:
            due = max(clock, _row_due(channel, bank))
            if due < best_due or (due == best_due and oldest_key < best_key):
                best_due, best_key, command = due, oldest_key, ROW
                best_bank, best_slot = bank_number, oldest
    channel["plan_bank"], channel["plan_slot"] = best_bank, best_slot
    return command, best_due


@step
def _or_close(spec, state, clock, number, only, kinds, planned):
    """The planned command, or the page policy's PRE if that comes before it."""
    idle_clocks = spec.page_timeout_clocks if spec.page_policy == _TIMEOUT else 0
    command, best_due = planned
    for bank_number in range(state.banks.shape[1]):
        bank = state.banks[number, bank_number]
        due = max(max(clock, bank["pre"]), bank["last_use"] + idle_clocks)
        is_open = bank["open_row"] != CLOSED
        if is_open and due < best_due and not _is_wanted(state, number, bank_number, only, kinds):
            command, best_due = CLOSE, due
            state.channels[number]["plan_bank"] = bank_number
    return command, best_due


@inlined_step
def _is_wanted(state, number, bank_number, only, kinds):
    """Whether a considered request wants the bank's open row."""
    if only != NOBODY:
        request = state.waiting[number, only]
        row = state.banks[number, bank_number]["open_row"]
        return request["bank"] == bank_number and request["row"] == row
    for kind in range(kinds[0], kinds[1]):
        if state.lists[number, bank_number, kind]["hit"] != NOBODY:
            return True
    return False
