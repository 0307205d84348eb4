"""The banks of a channel, to be believed: what is open, what each command sets, and what may issue when.

Every bound is a running maximum: a later command never lowers it.
"""

from __future__ import annotations

from archsim.model.causes import AtDram
from archsim.model.dram.spec import DramSpec

ACTIVATES_OF_WINDOW = 4  # n_faw: the window holds four ACT


class Bank:
    """One bank: the open row (None when closed) and the first memory clock of each command."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.open_row: int | None = None
        self.read_ready = self.write_ready = self.pre_ready = self.act_ready = 0
        self.last_use = 0  # clock of the last ACT or column command
        self.opened = 0  # clock of the last ACT
        self.closed = -1  # clock of the last PRE


class Banks:
    """The banks of one channel with the bounds that they share."""

    def __init__(self, spec: DramSpec):
        self.spec, self.timing = spec, spec.timing
        self.banks = [Bank(number) for number in range(spec.num_banks)]
        self.read_ready = self.write_ready = self.act_ready = 0
        self.activates: list[int] = []  # clocks of all ACT of the last window
        self.refresh = (0, 0)  # the last one: when it was due, when the banks could be used again
        self.written: tuple[int, Bank] | None = None  # the last data written: when it ended, where
        self.last_read: int | None = None  # clock of the last RD

    def __getitem__(self, number: int) -> Bank:
        return self.banks[number]

    def open_ones(self) -> list[Bank]:
        return [bank for bank in self.banks if bank.open_row is not None]

    def can_activate(self, m: int, bank: Bank) -> bool:
        return m >= bank.act_ready and m >= self.act_ready

    def can_read(self, m: int, bank: Bank) -> bool:
        return m >= bank.read_ready and m >= self.read_ready

    def can_write(self, m: int, bank: Bank) -> bool:
        return m >= bank.write_ready and m >= self.write_ready

    def activate(self, m: int, bank: Bank, row: int) -> None:
        timing = self.timing
        bank.open_row, bank.last_use, bank.opened = row, m, m
        bank.read_ready = max(bank.read_ready, m + timing.n_rcd_read)
        bank.write_ready = max(bank.write_ready, m + timing.n_rcd_write)
        bank.pre_ready = max(bank.pre_ready, m + timing.n_ras)
        bank.act_ready = max(bank.act_ready, m + timing.n_rc)
        for other in self._group_of(bank):
            other.act_ready = max(other.act_ready, m + timing.n_rrd_l)
        self.act_ready = max(self.act_ready, m + timing.n_rrd)
        self.activates = [*self.activates, m][-ACTIVATES_OF_WINDOW:]
        if timing.n_faw > 0 and len(self.activates) == ACTIVATES_OF_WINDOW:
            self.act_ready = max(self.act_ready, self.activates[0] + timing.n_faw)

    def precharge(self, m: int, bank: Bank) -> None:
        bank.open_row, bank.closed = None, m
        bank.act_ready = max(bank.act_ready, m + self.timing.n_rp)

    def refresh_all(self, m: int, due: int) -> None:
        self.refresh = (due, m + self.timing.n_rfc)
        for bank in self.banks:
            bank.act_ready = max(bank.act_ready, m + self.timing.n_rfc)

    def read(self, last: int, bank: Bank) -> None:
        """The RD of all bursts of a request, the last one in clock `last`."""
        timing = self.timing
        self._next_columns(last, bank)
        self.last_read = last
        self.write_ready = max(self.write_ready, last + timing.n_rtw)
        bank.pre_ready = max(bank.pre_ready, last + timing.n_rtp)

    def write(self, last: int, bank: Bank) -> None:
        """The WR of all bursts of a request, the last one in clock `last`."""
        timing = self.timing
        written = last + timing.n_wl + self.spec.burst_clocks
        self._next_columns(last, bank)
        self.written = (written, bank)
        self.read_ready = max(self.read_ready, written + timing.n_wtr)
        for other in self._group_of(bank):
            other.read_ready = max(other.read_ready, written + timing.n_wtr_l)
        bank.pre_ready = max(bank.pre_ready, written + timing.n_wr)

    def _next_columns(self, last: int, bank: Bank) -> None:
        """What any column command in `last` means for the next one."""
        bank.last_use = last
        self.read_ready = max(self.read_ready, last + self.timing.n_ccd)
        self.write_ready = max(self.write_ready, last + self.timing.n_ccd)
        for other in self._group_of(bank):
            other.read_ready = max(other.read_ready, last + self.timing.n_ccd_l)
            other.write_ready = max(other.write_ready, last + self.timing.n_ccd_l)

    def _group_of(self, bank: Bank) -> list[Bank]:
        """The banks of the same group, itself included; nobody where there are no groups."""
        groups = self.spec.num_groups
        return [b for b in self.banks if b.number % groups == bank.number % groups] if groups > 1 else []

    def waits(self, bank: Bank, arrival: int, is_write: bool) -> dict[AtDram, tuple[int, int]]:
        """From when to when a request that came at `arrival` and has its column command now waited for what.

        machine/README.md has the rule. The spans are in order; they may begin before it came.
        """
        timing = self.timing
        ready = bank.opened + (timing.n_rcd_write if is_write else timing.n_rcd_read)
        row_work = bank.opened - timing.n_rp if bank.closed >= arrival else bank.opened
        spans = {
            AtDram.REFRESH: self.refresh,
            AtDram.ACTIVATION: (max(row_work, self.refresh[1]), ready),
            AtDram.TURNAROUND: (0, 0),
        }
        turning = self._turning_to_write() if is_write else self._turning_to_read(bank)
        if turning is not None:
            spans[AtDram.TURNAROUND] = (max(turning[0], ready), turning[1])
        return spans

    def _turning_to_read(self, bank: Bank) -> tuple[int, int] | None:
        if self.written is None:
            return None
        ended, where = self.written
        same_group = self.spec.num_groups > 1 and where in self._group_of(bank)
        return ended, ended + (self.timing.n_wtr_l if same_group else self.timing.n_wtr)

    def _turning_to_write(self) -> tuple[int, int] | None:
        """Behind the last RD, from when another RD could have come."""
        if self.last_read is None:
            return None
        return self.last_read + self.timing.n_ccd, self.last_read + self.timing.n_rtw


def overlap(a: tuple[int, int], b: tuple[int, int]) -> int:
    """Clocks that are in both spans, each from its first to before its second."""
    return max(0, min(a[1], b[1]) - max(a[0], b[0]))
