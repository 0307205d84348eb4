"""A DRAM of independent channels: what it is. Every n_* is in memory clocks."""

from enum import IntEnum
from typing import NamedTuple


class Scheduler(IntEnum):
    """Which queued request a channel serves next."""

    FCFS = 0  # the oldest only
    FR_FCFS = 1  # the oldest that hits an open row, else the oldest
    IDEAL = 2  # all at once: every request is served when it arrives, without commands


class PagePolicy(IntEnum):
    """When a row is closed that no considered request wants."""

    OPEN = 0  # when another row of its bank is wanted, or for a refresh
    CLOSED = 1  # as soon as it may be
    TIMEOUT = 2  # page_timeout_clocks after its last use


class DramTiming(NamedTuple):
    """Data-sheet constraints in memory clocks. Those with _l hold within a bank group, where there are groups."""

    n_cl: int  # RD to first data
    n_wl: int  # WR to first data
    n_rcd_read: int  # ACT to RD, same bank
    n_rcd_write: int  # ACT to WR, same bank
    n_rp: int  # PRE to ACT, same bank
    n_ras: int  # ACT to PRE, same bank
    n_rc: int  # ACT to ACT, same bank
    n_rrd: int  # ACT to ACT, other bank of the channel
    n_rrd_l: int  # ACT to ACT, other bank of the group
    n_faw: int  # ACT to the fourth ACT after it, same channel; 0: no such rule
    n_ccd: int  # column command to column command
    n_ccd_l: int  # column command to column command, same group
    n_rtp: int  # RD to PRE, same bank
    n_wr: int  # last data written to PRE, same bank
    n_wtr: int  # last data written to RD, same channel
    n_wtr_l: int  # last data written to RD, same group
    n_rtw: int  # RD to WR, same channel
    n_rfc: int  # REF to ACT
    n_refi: int  # average time between REF commands, 0 switches refresh off


class AddressField(NamedTuple):
    """A bit field of the byte address."""

    shift: int
    bits: int


class DramSpec(NamedTuple):
    """`num_channels` channels, each with its own command and data bus and `num_banks` banks.

    Bank b belongs to group b % num_groups. Without a write queue, reads and writes share one queue.
    """

    num_channels: int
    num_banks: int
    num_groups: int  # 1: no bank groups
    period_ticks: int  # ticks of a memory clock
    burst_beats: int  # data beats of one column command
    clock_beats: int  # data beats of a memory clock
    beat_bytes: int  # bytes of one beat, the width of a channel
    num_queue_entries: int  # oldest requests (reads, if there is a write queue) that the scheduler sees
    num_write_entries: int  # oldest writes that it sees; 0: no write queue
    write_high: int  # waiting writes that start a drain
    write_low: int  # waiting writes that end it
    scheduler: int  # Scheduler
    max_wait_clocks: int  # FR_FCFS: a request that waited longer is served before all others
    page_policy: int  # PagePolicy
    page_timeout_clocks: int  # TIMEOUT: from the last use to the PRE
    channel: AddressField
    group: AddressField
    bank: AddressField  # within the group
    row: AddressField
    line: AddressField  # request within the row
    bank_hash: int  # lowest bits of the row that are XORed into the bank's number
    timing: DramTiming

    @property
    def burst_clocks(self) -> int:
        """Memory clocks that the data of one column command takes."""
        return self.burst_beats // self.clock_beats

    def read_clocks(self, num_bursts: int) -> int:
        """Memory clocks from anything that a channel does to the read that it answers by that, at least.

        Reads have `num_bursts` bursts or more.
        """
        if self.scheduler == Scheduler.IDEAL:
            return int(self.timing.n_cl)
        if self.num_write_entries > 0:
            return 1  # if the write queue has the data
        return int(self.timing.n_cl + (num_bursts - 1) * self.timing.n_ccd_l)
