"""What a read waited for, in the compiled DRAM: machine/README.md has the rule."""

from __future__ import annotations

from archsim.model.compiled import inlined_step


@inlined_step
def charge_read(spec, channel, bank, request, clock, last):
    """Count the clocks of a read whose RD is in `clock`, that of its last burst in `last`, by what they went into."""
    timing, arrival = spec.timing, request["clock"]
    ready = bank["opened"] + timing.n_rcd_read
    row_work = bank["opened"] - timing.n_rp if bank["closed"] >= arrival else bank["opened"]
    n_wtr = timing.n_wtr
    if spec.num_groups > 1 and channel["written_bank"] % spec.num_groups == request["bank"] % spec.num_groups:
        n_wtr = timing.n_wtr_l

    refresh = _overlap(arrival, clock, channel["refresh_began"], channel["refresh_ended"])
    activation = _overlap(arrival, clock, max(row_work, channel["refresh_ended"]), ready)
    turnaround = _overlap(arrival, clock, max(channel["written"], ready), channel["written"] + n_wtr)
    channel["read_refresh_clocks"] += refresh
    channel["read_activation_clocks"] += activation
    channel["read_turnaround_clocks"] += turnaround
    channel["read_queue_clocks"] += clock - arrival - refresh - activation - turnaround
    channel["read_bus_clocks"] += last - clock + timing.n_cl + spec.burst_beats // spec.clock_beats


@inlined_step
def _overlap(begin, end, other_begin, other_end):
    """Clocks that are in both spans, each from its begin to before its end."""
    return max(0, min(end, other_end) - max(begin, other_begin))
