"""What a channel of the compiled DRAM does next, and when: the scheduler and the page policy.

A plan holds until a command issues or a request enters that overtakes it. The candidate for a command that may issue
first is planned; of several, column commands come before row commands, and older requests before younger ones.
"""

from __future__ import annotations

from archsim.model.compiled import NEVER, inlined_step, step
from archsim.model.dram.compiled_commands import note_wishes, place_of, refresh_due
from archsim.model.dram.compiled_state import (
    BANK_BITS,
    CLOSE,
    CLOSED,
    COLUMN,
    NO_KEY,
    NO_WISH,
    NOBODY,
    PLAN_AGAIN,
    READS,
    REFRESH,
    ROW,
    ROW_BIT,
    TO_ACT,
    TO_PRE,
    WRITES,
)
from archsim.model.dram.spec import PagePolicy, Scheduler

_OPEN_PAGE, _TIMEOUT, _FCFS = int(PagePolicy.OPEN), int(PagePolicy.TIMEOUT), int(Scheduler.FCFS)
_WAIT_SHIFT = 50  # of a candidate: what may issue first comes first
_FAR = (1 << 12) - 1  # clocks; whoever must wait longer is looked at again then


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


@inlined_step
def plan(spec, state, clock, number):
    """Find out what the channel does next from `clock` on, if nobody enters before."""
    channel = state.channels[number]
    channel["is_strict"] = 0
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


@step
def overtakes(spec, state, clock, number, slot):
    """Whether a request that enters in `clock` changes what the channel does next, or may do so."""
    channel, request = state.channels[number], state.waiting[number, slot]
    if spec.num_write_entries > 0 or channel["plan"] == CLOSE:
        return True
    if channel["is_strict"] != 0:
        return False
    bank, kind = state.banks[number, request["bank"]], request["is_write"]
    requests = state.lists[number, request["bank"], kind]
    if bank["open_row"] == request["row"]:
        if requests["hit"] != slot:
            return False
        due = max(clock, _column_due(state, number, request["bank"], kind))
        is_before_row = channel["plan"] == ROW and (
            channel["plan_bank"] == request["bank"] or due == channel["plan_due"]
        )
        return is_before_row or due < channel["plan_due"]
    if requests["first"] != slot or state.lists[number, request["bank"], 1 - kind]["first"] != NOBODY:
        return False
    return max(clock, _row_due(state, number, request["bank"])) < channel["plan_due"]


@inlined_step
def needs_bus(timing, channel, clock):
    """Whether a burst of the last request still needs the command bus at `clock`."""
    before = channel["last_burst"] - clock
    return before >= 0 and before % timing.n_ccd_l == 0


@inlined_step
def _command(spec, state, clock, number):
    """The first command that may issue from `clock` on, and when; its bank and request are noted."""
    channel, draining = state.channels[number], 0
    first_kind, end_kind = READS, WRITES + 1 if channel["num_writes"] > 0 else READS + 1
    if spec.num_write_entries > 0:
        draining = drains(spec, channel)
        first_kind, end_kind = draining, draining + 1
        if channel["kinds"] != 1 << draining:
            channel["kinds"] = 1 << draining
            for bank_number in range(spec.num_banks):
                note_wishes(state, number, bank_number)

    only = NOBODY
    if spec.scheduler == _FCFS:
        only = _oldest(state, number, first_kind, end_kind)
    elif draining == 0:
        only = _out_of_patience(spec, state, clock, number, first_kind, end_kind)
    if only != NOBODY:
        channel["is_strict"] = 1 if channel["num_reads"] + channel["num_writes"] > 1 else 0
        command, due = _of_one(state, clock, number, only)
    else:
        command, due = _of_all(state, clock, number)
        patience_ends = channel["patience_ends"]
        if spec.scheduler != _FCFS and draining == 0 and patience_ends <= due < NEVER:
            command, due = PLAN_AGAIN, patience_ends
    if spec.page_policy != _OPEN_PAGE:
        command, due = _or_close(spec, state, clock, number, only, (first_kind, end_kind), (command, due))
    return command, due


@step
def _oldest(state, number, first_kind, end_kind):
    """The request that entered first, or NOBODY."""
    oldest, oldest_key = NOBODY, NO_KEY
    for bank_number in range(state.banks.shape[1]):
        for kind in range(first_kind, end_kind):
            requests = state.lists[number, bank_number, kind]
            if requests["first_key"] < oldest_key:
                oldest, oldest_key = int(requests["first"]), requests["first_key"]
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
    bank = request["bank"]
    channel["plan_bank"], channel["plan_slot"] = bank, slot
    if state.banks[number, bank]["open_row"] == request["row"]:
        return COLUMN, max(clock, _column_due(state, number, bank, request["is_write"]))
    return ROW, max(clock, _row_due(state, number, bank))


@inlined_step
def _column_due(state, number, bank, kind):
    """The first clock for the RD or WR of the open row."""
    return state.bounds[number, place_of(state, kind, bank)]


@inlined_step
def _row_due(state, number, bank):
    """The first clock for the ACT of a closed bank, or the PRE of an open one."""
    told = TO_ACT if state.banks[number, bank]["open_row"] == CLOSED else TO_PRE
    return state.bounds[number, place_of(state, told, bank)]


@inlined_step
def _of_all(state, clock, number):
    """The first command from `clock` on that any waiting request may have, and when.

    A candidate is one integer, so that finding the first one needs no branches: waiting clocks, then the wish.
    """
    channel, best = state.channels[number], NO_WISH
    for place in range(state.bounds.shape[1]):
        wait = min(max(state.bounds[number, place], clock) - clock, _FAR)
        best = min(best, (wait << _WAIT_SHIFT) + state.wishes[number, place])
    if best == NO_WISH:
        return PLAN_AGAIN, NEVER

    is_row, wait = best & ROW_BIT, best >> _WAIT_SHIFT
    bank, kind = best & ((1 << BANK_BITS) - 1), best >> BANK_BITS & 1
    requests = state.lists[number, bank, kind]
    first, hit = requests["first"], requests["hit"]
    channel["plan_bank"] = bank
    channel["plan_slot"] = first if is_row else hit
    return PLAN_AGAIN if wait == _FAR else ROW if is_row else COLUMN, clock + wait


@step
def _or_close(spec, state, clock, number, only, kinds, planned):
    """The planned command, or the page policy's PRE if that comes before it."""
    idle_clocks = spec.page_timeout_clocks if spec.page_policy == _TIMEOUT else 0
    command, best_due = planned
    for bank_number in range(state.banks.shape[1]):
        bank = state.banks[number, bank_number]
        pre_due = max(clock, state.bounds[number, place_of(state, TO_PRE, bank_number)])
        due = max(pre_due, bank["last_use"] + idle_clocks)
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
