"""A DRAM, to be believed: one process a channel that issues at most one command at every memory edge."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator

import simpy

from archsim.model.cache.reference import Kind, Request, timed
from archsim.model.causes import AtDram, first_cause
from archsim.model.dram.commands import Command
from archsim.model.dram.reference_banks import Bank, Banks, overlap
from archsim.model.dram.spec import AddressField, DramSpec, PagePolicy, Scheduler
from archsim.model.reference import Phase, at, call

Record = Callable[..., None]  # (clock, channel, command, bank, row, column, bursts)


def field(address: int, bits: AddressField) -> int:
    return (address >> bits.shift) & ((1 << bits.bits) - 1)


def divide_up(numerator: int, denominator: int) -> int:
    return -(-numerator // denominator)


def bank_of(spec: DramSpec, address: int) -> int:
    number = field(address, spec.bank) * spec.num_groups + field(address, spec.group)
    return number ^ (field(address, spec.row) & ((1 << spec.bank_hash) - 1))


def column_of(spec: DramSpec, address: int) -> int:
    """Bursts of the row that lie before the address."""
    fields = (spec.channel, spec.group, spec.bank, spec.line, spec.row)
    offset_bits = min((f.shift for f in fields if f.bits > 0), default=spec.row.shift)
    place = (field(address, spec.line) << offset_bits) + address % (1 << offset_bits)
    return place // (spec.burst_beats * spec.beat_bytes)


class Queued:
    """A request in a channel's queue, the `number`-th that came."""

    def __init__(self, request: Request, spec: DramSpec, now: int, number: int):
        self.request, self.number = request, number
        self.is_write = request.kind is not Kind.READ
        self.bank = bank_of(spec, request.address)
        self.row = field(request.address, spec.row)
        self.num_bursts = request.num_bytes // (spec.burst_beats * spec.beat_bytes)
        self.column = column_of(spec, request.address)
        self.arrival_clock = divide_up(now, spec.period_ticks)
        self.is_classified = False

    def is_answered_by(self, write: Queued) -> bool:
        """Whether a write that came before this read holds all of its data."""
        ours, its = self.request, write.request
        same = its.address == ours.address and its.num_bytes >= ours.num_bytes
        return same and write.number < self.number


class Channel:
    """One channel, the DRAM being `level`. Its answers can be used from a core edge on."""

    def __init__(
        self, spec: DramSpec, env: simpy.Environment, index: int, level: int, core_period_ticks: int
    ):
        self.spec, self.env, self.index = spec, env, index
        self.first_cause = first_cause(level)
        self.core_period_ticks = core_period_ticks
        self.reads: list[Queued] = []  # the oldest first
        self.writes = (
            [] if spec.num_write_entries > 0 else self.reads
        )  # without a queue of their own: one queue
        self.is_draining = False  # whether writes are served
        self.num_arrived = 0
        self.banks = Banks(spec)
        self.data_end = 0  # when the data of all requests served so far has moved
        self.burst_clocks: list[int] = []  # when the last column command needs the command bus
        self.next_refresh = spec.timing.n_refi

        self.counts: Counter[str] = Counter()
        self.record: Record = lambda *command: None

    def arrive(self, request: Request) -> None:
        """`request` is here now."""
        self.num_arrived += 1
        queued = Queued(request, self.spec, int(self.env.now), self.num_arrived)
        request.wait.mark(int(self.env.now), self.first_cause + AtDram.QUEUE)
        (self.writes if queued.is_write else self.reads).append(queued)

    def has_room(self, is_write: bool) -> bool:
        """Whether a request that came now would be among those that the scheduler sees."""
        if is_write and self.spec.num_write_entries > 0:
            return len(self.writes) < self.spec.num_write_entries
        return len(self.reads) < self.spec.num_queue_entries

    def is_quiet(self) -> bool:
        """No request waits for its column command."""
        return not self.reads and not self.writes

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: phase 3 of every memory edge."""
        clock = 0
        while True:
            yield at(self.env, clock * self.spec.period_ticks, Phase.COMMAND, self.index)
            if self.spec.scheduler == Scheduler.IDEAL:
                self._serve_all(clock)
            else:
                self._play(clock)
            clock += 1

    def _play(self, m: int) -> None:
        self._consider(m, self.reads, self.spec.num_queue_entries)
        if self.spec.num_write_entries > 0:
            self._consider(m, self.writes, self.spec.num_write_entries)
            self._choose_direction()
        if m in self.burst_clocks:
            return
        if self.spec.timing.n_refi > 0 and m >= self.next_refresh:
            self._refresh(m)
        else:
            self._serve(m)

    def _serve_all(self, m: int) -> None:
        """IDEAL: whatever is here is served, as if its row were open."""
        for queued in self.reads:
            self.data_end = m + self.spec.timing.n_cl
            self.counts["row_hits"] += 1
            self.counts["waited_clocks"] += m - queued.arrival_clock
            self.counts["data_clocks"] += queued.num_bursts * self.spec.burst_clocks
            self.counts["writes" if queued.is_write else "reads"] += 1
            if not queued.is_write:
                self.counts["read_bus_clocks"] += self.spec.timing.n_cl
            queued.request.wait.mark(m * self.spec.period_ticks, self.first_cause + AtDram.BUS)
            if queued.request.answer is not None:
                self._answer(m + self.spec.timing.n_cl, 0, queued.request)
        self.reads.clear()

    def _consider(self, m: int, queue: list[Queued], num_entries: int) -> None:
        """Look for the first time at what is now among the `num_entries` oldest: forward or classify it."""
        place = 0
        while place < min(len(queue), num_entries):
            queued = queue[place]
            if not queued.is_classified and self._can_forward(queued):
                queue.remove(queued)
                self.counts["forwarded"] += 1
                self.counts["waited_clocks"] += m - queued.arrival_clock
                self.counts["forwarded_bytes"] += queued.request.num_bytes
                self._answer(m + 1, 0, queued.request)
                continue
            if not queued.is_classified:
                self._classify(queued)
            place += 1

    def _can_forward(self, queued: Queued) -> bool:
        """Whether a write that waits in the write queue holds a read's data."""
        if queued.is_write or self.spec.num_write_entries == 0:
            return False
        return any(queued.is_answered_by(write) for write in self.writes)

    def _classify(self, queued: Queued) -> None:
        queued.is_classified = True
        open_row = self.banks[queued.bank].open_row
        if open_row is None:
            self.counts["row_misses"] += 1
        elif open_row == queued.row:
            self.counts["row_hits"] += 1
        else:
            self.counts["row_conflicts"] += 1

    def _choose_direction(self) -> None:
        """Serve writes from the high mark down to the low one, or while no read waits."""
        num_writes = min(len(self.writes), self.spec.num_write_entries)
        if not self.reads or not self.writes:
            self.is_draining = bool(self.writes)
        elif self.is_draining:
            self.is_draining = num_writes > self.spec.write_low
        else:
            self.is_draining = num_writes >= self.spec.write_high

    def _refresh(self, m: int) -> None:
        """A refresh is due: close all banks, then REF, each as soon as it may be."""
        open_ones = self.banks.open_ones()
        if open_ones:
            if all(m >= bank.pre_ready for bank in open_ones):
                self.counts["precharges"] += 1
                self.record(m, self.index, Command.PREA, 0, 0, 0, 0)
                for bank in open_ones:
                    self.banks.precharge(m, bank)
        elif all(m >= bank.act_ready for bank in self.banks.banks):
            self.counts["refreshes"] += 1
            self.record(m, self.index, Command.REF, 0, 0, 0, 0)
            self.banks.refresh_all(m, self.next_refresh)
            self.next_refresh += self.spec.timing.n_refi

    def _serve(self, m: int) -> None:
        """A column command for the oldest that can have one, else a row command for the oldest that can."""
        considered = self._considered(m)
        for queued in considered:
            if self._can_have_column(m, queued):
                self._column(m, queued)
                return
        for place, queued in enumerate(considered):
            is_oldest_of_bank = all(older.bank != queued.bank for older in considered[:place])
            if is_oldest_of_bank and self._row_command(m, queued, considered):
                return
        self._close_unwanted(m, considered)

    def _considered(self, m: int) -> list[Queued]:
        if self.is_draining:
            window = self.writes[: self.spec.num_write_entries]
        else:
            window = self.reads[: self.spec.num_queue_entries]
        if self.spec.scheduler == Scheduler.FCFS:
            return window[:1]
        if window and not self.is_draining and m - window[0].arrival_clock > self.spec.max_wait_clocks:
            return window[:1]
        return window

    def _can_have_column(self, m: int, queued: Queued) -> bool:
        bank = self.banks[queued.bank]
        if bank.open_row != queued.row:
            return False
        return self.banks.can_write(m, bank) if queued.is_write else self.banks.can_read(m, bank)

    def _row_command(self, m: int, queued: Queued, considered: list[Queued]) -> bool:
        """ACT or PRE for `queued` if it needs one that is allowed; True when one was issued."""
        bank = self.banks[queued.bank]
        if bank.open_row is None:
            if self.banks.can_activate(m, bank):
                self.counts["activates"] += 1
                self.record(m, self.index, Command.ACT, bank.number, queued.row, 0, 0)
                self.banks.activate(m, bank, queued.row)
                return True
        elif m >= bank.pre_ready and not _is_wanted(bank, considered):
            self._precharge(m, bank)
            return True
        return False

    def _close_unwanted(self, m: int, considered: list[Queued]) -> None:
        """The page policy: PRE of the first bank whose row nobody considered wants, once it is time."""
        spec = self.spec
        if spec.page_policy == PagePolicy.OPEN:
            return
        idle_clocks = spec.page_timeout_clocks if spec.page_policy == PagePolicy.TIMEOUT else 0
        for bank in self.banks.open_ones():
            is_time = m >= bank.pre_ready and m >= bank.last_use + idle_clocks
            if is_time and not _is_wanted(bank, considered):
                self._precharge(m, bank)
                return

    def _precharge(self, m: int, bank: Bank) -> None:
        self.counts["precharges"] += 1
        self.record(m, self.index, Command.PRE, bank.number, bank.open_row, 0, 0)
        self.banks.precharge(m, bank)

    def _column(self, m: int, queued: Queued) -> None:
        """RD or WR of all bursts of a line, the first at `m`; the request leaves its queue."""
        spec, bank, bursts = self.spec, self.banks[queued.bank], queued.num_bursts
        self.burst_clocks = [m + burst * spec.timing.n_ccd_l for burst in range(bursts)]
        last = self.burst_clocks[-1]
        self.counts["data_clocks"] += bursts * spec.burst_clocks
        self.counts["waited_clocks"] += m - queued.arrival_clock
        command = Command.WR if queued.is_write else Command.RD
        self.record(m, self.index, command, bank.number, queued.row, queued.column, bursts)
        self._tell(m, queued)
        to_data = spec.timing.n_wl if queued.is_write else spec.timing.n_cl
        self.data_end = max(self.data_end, last + to_data + spec.burst_clocks)
        if queued.is_write:
            self.writes.remove(queued)
            self.counts["writes"] += 1
            self.banks.write(last, bank)
        else:
            self.reads.remove(queued)
            self.counts["reads"] += 1
            self._charge(m, queued)
            self.counts["read_bus_clocks"] += last + spec.timing.n_cl + spec.burst_clocks - m
            self.banks.read(last, bank)
        if queued.request.answer is not None:
            self._answer(last + to_data, spec.burst_beats - 1, queued.request)

    def _charge(self, m: int, queued: Queued) -> None:
        """Count the clocks of a read that has its RD in `m` by what they went into."""
        arrival = queued.arrival_clock
        waits = self.banks.waits(self.banks[queued.bank], arrival, queued.is_write)
        clocks = {cause: overlap((arrival, m), span) for cause, span in waits.items()}
        for cause, number in clocks.items():
            self.counts[f"read_{cause.name.lower()}_clocks"] += number
        self.counts["read_queue_clocks"] += m - arrival - sum(clocks.values())

    def _tell(self, m: int, queued: Queued) -> None:
        """Mark what a request that has its column command in `m` waited for, also before it came."""
        period, wait = self.spec.period_ticks, queued.request.wait
        waits = self.banks.waits(self.banks[queued.bank], queued.arrival_clock, queued.is_write)
        for cause, (begin, end) in waits.items():
            if end > begin:
                wait.mark(begin * period, self.first_cause + cause)
                wait.mark(end * period, self.first_cause + AtDram.QUEUE)
        wait.mark(m * period, self.first_cause + AtDram.BUS)

    def _answer(self, clock: int, beats: int, request: Request) -> None:
        """The fill at the first core edge at or after `beats` beats from `clock`, which may fall between two ticks."""
        data_beats = clock * self.spec.clock_beats + beats
        edge = divide_up(data_beats * self.spec.period_ticks, self.spec.clock_beats * self.core_period_ticks)
        tick = edge * self.core_period_ticks
        assert request.answer is not None
        call(at(self.env, tick, Phase.FILL), request.answer, tick)


class Dram:
    """All channels: a request goes to the channel that its address names."""

    def __init__(self, spec: DramSpec, env: simpy.Environment, level: int, core_period_ticks: int):
        self.spec, self.env, self.core_period_ticks = spec, env, core_period_ticks
        self.latencies: Counter[int] = Counter()  # in core cycles, of the requests answered, by class
        self.channels = [
            Channel(spec, env, index, level, core_period_ticks) for index in range(spec.num_channels)
        ]

    def record(self, commands: list[tuple[int, ...]]) -> None:
        """From now on, append every command to `commands`, as the fields of a COMMAND."""
        for channel in self.channels:
            channel.record = lambda *command: commands.append(command)

    def channel_of(self, address: int) -> Channel:
        return self.channels[field(address, self.spec.channel)]

    def cut(self, address: int, num_bytes: int) -> list[tuple[int, int]]:
        """(address, bytes) of the whole bursts that these bytes of one line lie in."""
        burst = self.spec.burst_beats * self.spec.beat_bytes
        start = address // burst * burst
        return [(start, divide_up(address + num_bytes, burst) * burst - start)]

    def arrive(self, request: Request) -> None:
        if request.taken is not None:
            request.taken()
        answer = timed(request.answer, self.latencies, int(self.env.now), self.core_period_ticks)
        self.channel_of(request.address).arrive(request._replace(answer=answer))

    def is_quiet(self) -> bool:
        """No request waits for its column command."""
        return all(channel.is_quiet() for channel in self.channels)


def _is_wanted(bank: Bank, considered: list[Queued]) -> bool:
    """Whether a considered request wants the bank's open row."""
    return any(other.bank == bank.number and other.row == bank.open_row for other in considered)
