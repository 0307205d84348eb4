"""A DRAM of independent channels: what it is. Every n_* is in memory clocks."""

from enum import IntEnum
from typing import NamedTuple


class Scheduler(IntEnum):
    """Which queued request a channel serves next."""

    FCFS = 0  # the oldest only
    FR_FCFS = 1  # the oldest that hits an open row, else the oldest


class DramTiming(NamedTuple):
    """Data-sheet constraints in memory clocks ([Qimonda] HYB18H512321AF, [Samsung] K4J55323QF)."""

    n_cl: int  # RD to first data
    n_wl: int  # WR to first data
    n_rcd_read: int  # ACT to RD, same bank
    n_rcd_write: int  # ACT to WR, same bank
    n_rp: int  # PRE to ACT, same bank
    n_ras: int  # ACT to PRE, same bank
    n_rc: int  # ACT to ACT, same bank
    n_rrd: int  # ACT to ACT, other bank of the channel
    n_ccd: int  # column command to column command
    n_rtp: int  # RD to PRE, same bank
    n_wr: int  # last data written to PRE, same bank
    n_wtr: int  # last data written to RD, same channel
    n_rtw: int  # RD to WR, same channel
    n_rfc: int  # REF to ACT
    n_refi: int  # average time between REF commands, 0 switches refresh off


class AddressField(NamedTuple):
    """A bit field of the byte address."""

    shift: int
    bits: int


class DramSpec(NamedTuple):
    """`num_channels` channels, each with its own command and data bus and `num_banks` banks."""

    num_channels: int
    num_banks: int
    period_ticks: int  # ticks of a memory clock
    burst_beats: int  # data beats of one column command, two a clock
    beat_bytes: int  # bytes of one beat, the width of a channel
    num_queue_entries: int  # oldest requests of a channel that the scheduler sees
    scheduler: int  # Scheduler
    max_wait_clocks: int  # FR_FCFS: a request that waited longer is served before all others
    channel: AddressField
    bank: AddressField
    row: AddressField
    timing: DramTiming
