"""Closed forms: the unloaded latency of a machine of 2004, and bandwidth that never passes the peak."""

from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings

from archsim.machine import compiled
from archsim.machine.spec import MachineSpec
from archsim.model.cache.spec import DRAM_PARENT, CacheSpec
from archsim.model.dram.spec import AddressField, DramSpec, DramTiming, PagePolicy, Scheduler
from archsim.trace.records import num_instructions
from archsim.trace.stream import whole
from tests.machine.build import CORE, MACHINE, both_models, load, work
from tests.machine.strategies import many_tasks, plays

# 256-Mbit x32 GDDR3 at 700 MHz: [Samsung] K4J55323QF-14 (CL, WL), [Qimonda] HYB18H512321AF-14 (rows).
GDDR3_700 = DramTiming(
    n_cl=9,
    n_wl=5,
    n_rcd_read=11,
    n_rcd_write=5,
    n_rp=12,
    n_ras=18,
    n_rc=30,
    n_rrd=7,
    n_rrd_l=7,
    n_faw=0,
    n_ccd=4,
    n_ccd_l=4,
    n_rtp=4,
    n_wr=8,
    n_wtr=5,
    n_wtr_l=5,
    n_rtw=10,
    n_rfc=37,
    n_refi=0,
)

# [Johnson04] table 2 and section 6: 1.2 GHz, 16 KiB L1 of 64-byte lines, 256 KiB L2 of 128-byte lines, 8 channels.
JOHNSON = MachineSpec(
    core=CORE._replace(period_ticks=7),
    core_cache=(0,),
    locks=MACHINE.locks,
    source=MACHINE.source,
    fifo=MACHINE.fifo,
    caches=(
        CacheSpec(32, 8, 64, hit_cycles=1, num_mshrs=8, num_targets=8, num_ports=1, parent=1),
        CacheSpec(256, 8, 128, hit_cycles=6, num_mshrs=16, num_targets=8, num_ports=1, parent=DRAM_PARENT),
    ),
    dram=DramSpec(
        num_channels=8,
        num_banks=4,
        num_groups=1,
        period_ticks=12,
        burst_beats=8,
        clock_beats=2,
        beat_bytes=4,
        num_queue_entries=16,
        num_write_entries=0,
        write_high=0,
        write_low=0,
        scheduler=Scheduler.FR_FCFS,
        max_wait_clocks=1000,
        page_policy=PagePolicy.OPEN,
        page_timeout_clocks=0,
        channel=AddressField(shift=7, bits=3),
        bank=AddressField(shift=14, bits=2),
        row=AddressField(shift=16, bits=12),
        group=AddressField(shift=0, bits=0),
        line=AddressField(shift=10, bits=4),
        bank_hash=0,
        timing=GDDR3_700,
    ),
)
SAME_ROW, OTHER_ROW = 1024, 65536
EDGE = 5  # a LOAD in cycle 5 modulo 12 reaches the DRAM 7 cycles later, when both clocks have an edge


@both_models
@pytest.mark.parametrize(
    ("steps", "cycles_below_l2"),
    [
        ([load(0), 7, load(SAME_ROW)], 42),  # 12 + 9 + 3.5 clocks are 294 ticks
        ([EDGE, load(0)], 61),  # + 11 clocks: 426 ticks
        ([EDGE, load(0), 28, load(OTHER_ROW)], 82),  # + 12 clocks: 570 ticks
    ],
    ids=["row hit", "row miss", "row conflict"],
)
def test_the_latency_below_the_l2(simulate, steps, cycles_below_l2):
    before = simulate(JOHNSON, work(steps[:-1])).cache_fetch_ticks
    after = simulate(JOHNSON, work(steps)).cache_fetch_ticks

    assert (after - before).tolist() == [(6 + cycles_below_l2) * 7, cycles_below_l2 * 7]


@both_models
def test_the_latency_of_hits(simulate):
    """An L1 hit costs 1 cycle; an L1 miss that hits in the L2 1 + 6 cycles."""
    cold = simulate(JOHNSON, work([load(0)])).cycles
    l1_hit = simulate(JOHNSON, work([load(0), load(0)])).cycles
    l2_hit = simulate(JOHNSON, work([load(0), load(64)])).cycles

    assert (l1_hit - cold, l2_hit - cold) == (1, 1 + 6)


@both_models
def test_streaming_reads_come_near_the_peak_of_a_channel(simulate):
    """One channel, a row of 16 lines of 16 clocks each: the next row is opened meanwhile, in another bank."""
    one = JOHNSON.dram._replace(num_channels=1, channel=AddressField(0, 0))
    one = one._replace(bank=AddressField(11, 2), row=AddressField(13, 12))
    spec = JOHNSON._replace(core=JOHNSON.core._replace(num_threads=8), dram=one)
    counters = simulate(spec, work(*[[load(line * 128)] for line in range(256)]))

    clocks = counters.cycles * 7 / 12
    busy = counters.dram_data_clocks[0] / clocks
    assert counters.dram_data_clocks[0] == 256 * 16
    assert 0.95 < busy <= 1


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(plays(many_tasks()))
def test_no_core_issues_more_than_an_instruction_a_cycle(played):
    spec, drawn = played
    counters = compiled.simulate(spec, whole(drawn))

    assert counters.cycles * spec.core.num_cores >= num_instructions(drawn)


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(plays(many_tasks()))
def test_no_fetch_is_faster_than_an_open_row(played):
    """All bursts of a sector, the read latency, and the beats of the last burst; a write that waits may be faster."""
    spec, drawn = played
    counters, dram = compiled.simulate(spec, whole(drawn)), spec.dram

    clocks = Fraction(dram.timing.n_cl)
    if dram.scheduler != Scheduler.IDEAL:
        bursts = max(1, spec.caches[-1].sector_bytes // (dram.burst_beats * dram.beat_bytes))
        clocks += (bursts - 1) * dram.timing.n_ccd_l + Fraction(dram.burst_beats - 1, dram.clock_beats)
    below = [index for index, cache in enumerate(spec.caches) if cache.parent == DRAM_PARENT]
    served = int(counters.cache_fetches[below].sum()) - int(counters.dram_forwarded.sum())
    assert counters.cache_fetch_ticks[below].sum() >= served * clocks * dram.period_ticks
