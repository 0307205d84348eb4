"""A DRAM, to be believed: one process a channel that issues at most one command at every memory edge."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator

import simpy

from archsim.model.cache.reference import Kind, Request
from archsim.model.dram.spec import AddressField, DramSpec, Scheduler
from archsim.model.reference import Phase, at, call


def field(address: int, bits: AddressField) -> int:
    return (address >> bits.shift) & ((1 << bits.bits) - 1)


def divide_up(numerator: int, denominator: int) -> int:
    return -(-numerator // denominator)


class Queued:
    """A request in a channel's queue."""

    def __init__(self, request: Request, spec: DramSpec, now: int):
        self.request = request
        self.is_write = request.kind is Kind.WRITEBACK
        self.bank = field(request.address, spec.bank)
        self.row = field(request.address, spec.row)
        self.num_bursts = request.num_bytes // (spec.burst_beats * spec.beat_bytes)
        self.arrival_clock = divide_up(now, spec.period_ticks)
        self.is_classified = False


class Bank:
    """One bank: the open row (None when closed) and the first memory clock of each command."""

    def __init__(self) -> None:
        self.open_row: int | None = None
        self.read_ready = self.write_ready = self.pre_ready = self.act_ready = 0


class Channel:
    """One channel. Its answers are charged to `supplier`; they can be used from a core edge on."""

    def __init__(
        self, spec: DramSpec, env: simpy.Environment, index: int, supplier: int, core_period_ticks: int
    ):
        self.spec, self.env, self.index, self.supplier = spec, env, index, supplier
        self.core_period_ticks = core_period_ticks
        self.queue: list[Queued] = []  # the oldest first
        self.banks = [Bank() for _ in range(spec.num_banks)]
        self.read_ready = self.write_ready = self.act_ready = 0
        self.burst_clocks: list[int] = []  # when the last column command needs the command bus
        self.next_refresh = spec.timing.n_refi

        self.counts: Counter[str] = Counter()

    def arrive(self, request: Request) -> None:
        """`request` is here now."""
        self.queue.append(Queued(request, self.spec, int(self.env.now)))

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: phase 3 of every memory edge."""
        clock = 0
        while True:
            yield at(self.env, clock * self.spec.period_ticks, Phase.COMMAND, self.index)
            self._classify()
            if clock in self.burst_clocks:
                pass
            elif self.spec.timing.n_refi > 0 and clock >= self.next_refresh:
                self._refresh(clock)
            else:
                self._serve(clock)
            clock += 1

    def _classify(self) -> None:
        for queued in self.queue[: self.spec.num_queue_entries]:
            if not queued.is_classified:
                queued.is_classified = True
                open_row = self.banks[queued.bank].open_row
                if open_row is None:
                    self.counts["row_misses"] += 1
                elif open_row == queued.row:
                    self.counts["row_hits"] += 1
                else:
                    self.counts["row_conflicts"] += 1

    def _refresh(self, m: int) -> None:
        """A refresh is due: close all banks, then REF, each as soon as it may be."""
        timing = self.spec.timing
        is_open = [bank for bank in self.banks if bank.open_row is not None]
        if is_open:
            if all(m >= bank.pre_ready for bank in is_open):
                self.counts["precharges"] += 1
                for bank in is_open:
                    _close(bank, m + timing.n_rp)
        elif all(m >= bank.act_ready for bank in self.banks):
            self.counts["refreshes"] += 1
            self.next_refresh += timing.n_refi
            for bank in self.banks:
                bank.act_ready = max(bank.act_ready, m + timing.n_rfc)

    def _serve(self, m: int) -> None:
        """A column command for the oldest that can have one, else a row command for the oldest that can."""
        considered = self._considered(m)
        for queued in considered:
            if self._column_allowed(m, queued):
                self.queue.remove(queued)
                self._column(m, queued)
                return
        for place, queued in enumerate(considered):
            is_oldest_of_bank = all(older.bank != queued.bank for older in considered[:place])
            if is_oldest_of_bank and self._row_command(m, queued, considered):
                return

    def _considered(self, m: int) -> list[Queued]:
        window = self.queue[: self.spec.num_queue_entries]
        if self.spec.scheduler == Scheduler.FCFS:
            return window[:1]
        if window and m - window[0].arrival_clock > self.spec.max_wait_clocks:
            return window[:1]
        return window

    def _column_allowed(self, m: int, queued: Queued) -> bool:
        bank = self.banks[queued.bank]
        if bank.open_row != queued.row:
            return False
        if queued.is_write:
            return m >= bank.write_ready and m >= self.write_ready
        return m >= bank.read_ready and m >= self.read_ready

    def _row_command(self, m: int, queued: Queued, considered: list[Queued]) -> bool:
        """ACT or PRE for `queued` if it needs one that is allowed; True when one was issued."""
        bank = self.banks[queued.bank]
        if bank.open_row is None:
            if m >= bank.act_ready and m >= self.act_ready:
                self._activate(m, bank, queued.row)
                return True
        elif bank.open_row != queued.row:
            is_wanted = any(other.bank == queued.bank and other.row == bank.open_row for other in considered)
            if m >= bank.pre_ready and not is_wanted:
                self.counts["precharges"] += 1
                _close(bank, m + self.spec.timing.n_rp)
                return True
        return False

    def _activate(self, m: int, bank: Bank, row: int) -> None:
        timing = self.spec.timing
        self.counts["activates"] += 1
        bank.open_row = row
        bank.read_ready = max(bank.read_ready, m + timing.n_rcd_read)
        bank.write_ready = max(bank.write_ready, m + timing.n_rcd_write)
        bank.pre_ready = max(bank.pre_ready, m + timing.n_ras)
        bank.act_ready = max(bank.act_ready, m + timing.n_rc)
        self.act_ready = max(self.act_ready, m + timing.n_rrd)

    def _column(self, m: int, queued: Queued) -> None:
        """RD or WR of all bursts of a line, the first at `m`."""
        n_ccd = self.spec.timing.n_ccd
        self.burst_clocks = [m + burst * n_ccd for burst in range(queued.num_bursts)]
        self.counts["data_clocks"] += queued.num_bursts * self.spec.burst_beats // 2
        next_column = m + queued.num_bursts * n_ccd
        if queued.is_write:
            self._write(self.burst_clocks[-1], next_column, self.banks[queued.bank])
        else:
            self._read(self.burst_clocks[-1], next_column, self.banks[queued.bank])
            self._answer(self.burst_clocks[-1], queued.request)

    def _read(self, last: int, next_column: int, bank: Bank) -> None:
        timing = self.spec.timing
        self.counts["reads"] += 1
        self.read_ready = max(self.read_ready, next_column)
        self.write_ready = max(self.write_ready, last + timing.n_rtw)
        bank.pre_ready = max(bank.pre_ready, last + timing.n_rtp)

    def _write(self, last: int, next_column: int, bank: Bank) -> None:
        timing = self.spec.timing
        self.counts["writes"] += 1
        written = last + timing.n_wl + self.spec.burst_beats // 2
        self.write_ready = max(self.write_ready, next_column)
        self.read_ready = max(self.read_ready, written + timing.n_wtr)
        bank.pre_ready = max(bank.pre_ready, written + timing.n_wr)

    def _answer(self, last: int, request: Request) -> None:
        """The fill at the first core edge at or after the last beat, which may fall between two ticks."""
        half_clocks = 2 * (last + self.spec.timing.n_cl) + self.spec.burst_beats - 1
        edge = divide_up(half_clocks * self.spec.period_ticks, 2 * self.core_period_ticks)
        tick = edge * self.core_period_ticks
        assert request.answer is not None
        call(at(self.env, tick, Phase.FILL), request.answer, tick, self.supplier)


class Dram:
    """All channels: a request goes to the channel that its address names."""

    def __init__(self, spec: DramSpec, env: simpy.Environment, supplier: int, core_period_ticks: int):
        self.spec = spec
        self.channels = [
            Channel(spec, env, index, supplier, core_period_ticks) for index in range(spec.num_channels)
        ]

    def arrive(self, request: Request) -> None:
        self.channels[field(request.address, self.spec.channel)].arrive(request)

    def is_quiet(self) -> bool:
        """No request waits for its column command."""
        return not any(channel.queue for channel in self.channels)


def _close(bank: Bank, act_ready: int) -> None:
    bank.open_row = None
    bank.act_ready = max(bank.act_ready, act_ready)
