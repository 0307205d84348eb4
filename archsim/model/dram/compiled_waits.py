"""What a request waited for, in the compiled DRAM: machine/README.md has the rule."""

from __future__ import annotations

from archsim.model.compiled import inlined_step


@inlined_step
def find_wait(spec, state, number, slot, clock):
    """Note what the request in this slot, whose column command is in `clock`, waited for."""
    request, wait, channel = state.waiting[number, slot], state.waits[number], state.channels[number]
    timing, bank = spec.timing, state.banks[number, request["bank"]]
    row_work = bank["opened"] - timing.n_rp if bank["closed"] >= request["clock"] else bank["opened"]
    if request["is_write"] != 0:
        ready = bank["opened"] + timing.n_rcd_write
        turning, turned = channel["last_read"] + timing.n_ccd, channel["last_read"] + timing.n_rtw
    else:
        ready = bank["opened"] + timing.n_rcd_read
        turning, turned = channel["written"], channel["written"] + timing.n_wtr
        if spec.num_groups > 1 and _same_group(spec, channel["written_bank"], request["bank"]):
            turned = channel["written"] + timing.n_wtr_l

    wait["refreshing"], wait["refreshed"] = channel["refresh_began"], channel["refresh_ended"]
    wait["opening"], wait["opened"] = max(row_work, channel["refresh_ended"]), ready
    wait["turning"], wait["turned"] = max(turning, ready), turned
    wait["column"] = clock


@inlined_step
def _same_group(spec, bank, other):
    return bank % spec.num_groups == other % spec.num_groups


@inlined_step
def served_at(state, number, clock):
    """The request that is answered without a command waited for others, and from `clock` on, if ever, for its data."""
    wait = state.waits[number]
    wait["refreshing"] = wait["refreshed"] = wait["opening"] = wait["opened"] = 0
    wait["turning"] = wait["turned"] = 0
    wait["column"] = clock


@inlined_step
def charge_read(spec, state, number, arrival, last):
    """Count the clocks of a read, whose last burst is in clock `last`, by what they went into."""
    channel, wait = state.channels[number], state.waits[number]
    clock = wait["column"]
    refresh = _overlap(arrival, clock, wait["refreshing"], wait["refreshed"])
    activation = _overlap(arrival, clock, wait["opening"], wait["opened"])
    turnaround = _overlap(arrival, clock, wait["turning"], wait["turned"])
    channel["read_refresh_clocks"] += refresh
    channel["read_activation_clocks"] += activation
    channel["read_turnaround_clocks"] += turnaround
    channel["read_queue_clocks"] += clock - arrival - refresh - activation - turnaround
    channel["read_bus_clocks"] += last - clock + spec.timing.n_cl + spec.burst_beats // spec.clock_beats


@inlined_step
def _overlap(begin, end, other_begin, other_end):
    """Clocks that are in both spans, each from its begin to before its end."""
    return max(0, min(end, other_end) - max(begin, other_begin))
