"""A delay stream, to be believed: offsets into an endless stream of bytes, of which the ring holds a part."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator

import simpy

from archsim.model.cache.reference import Answer, Kind
from archsim.model.delay_stream.spec import DelayStreamSpec, Overflow
from archsim.model.reference import Phase, Registered, Stays, at
from archsim.model.waiting import Wait

Send = Callable[[int, Kind, int, int, Answer, Wait], None]  # (tick, kind, address, bytes, answer, wait)


class Transfer:
    """A write or a read under way, of the bytes from `begin` to before `end`."""

    def __init__(self, begin: int, end: int):
        self.begin, self.end = begin, end
        self.wait = Wait()
        self.is_done = False
        self.came: int | None = None  # tick in which it and all before it were done

    def is_over(self, now: int) -> bool:
        """Whether that was before this tick."""
        return self.came is not None and self.came < now


class DelayStream:
    """One delay stream. Counts bytes from the start of the run; what was taken is a part of what was read, that of
    what was asked for, of what was written, of what was sent, of what was put in.
    """

    def __init__(
        self, spec: DelayStreamSpec, env: simpy.Environment, index: int, period_ticks: int, send: Send
    ):
        self.spec, self.env, self.index, self.period_ticks, self.send = spec, env, index, period_ticks, send
        self.ends: deque[int] = deque()  # of the items that were not taken
        self.pushed, self.released, self.read, self.taken = (Registered() for _ in range(4))
        self.stays = Stays()  # of bytes
        self.sent = self.written = self.asked = 0
        self.writes: deque[Transfer] = deque()
        self.reads: deque[Transfer] = deque()
        self.reading: deque[Transfer] = (
            deque()
        )  # the same, as seen from outside: what came now is still to come
        self.writing: deque[Transfer] = deque()
        self.last_move = 0  # tick of the last request, answer or early release

        self.num_put = self.num_taken = self.peak_bytes = 0
        self.num_writes = self.num_reads = self.marks = self.early = 0

    def put(self, now: int, num_bytes: int) -> bool:
        """Whether the item had room."""
        if self.spec.overflow == Overflow.RELEASE:
            self._release_early(now, self.pushed.count + num_bytes - self.spec.ring_bytes)
        if self.pushed.count + num_bytes - self.taken.seen(now) > self.spec.ring_bytes:
            return False
        self.pushed.add(now, num_bytes)
        self.ends.append(self.pushed.count)
        self.stays.come(now, num_bytes)
        self.num_put += 1
        self.peak_bytes = max(self.peak_bytes, self.pushed.count - self.taken.seen(now))
        return True

    def _release_early(self, now: int, least: int) -> None:
        """Release as few items as bring the released bytes to `least`."""
        for end in self.ends:
            if self.released.count >= least:
                return
            if end > self.released.count:
                self.released.add(now, end - self.released.count)
                self.early += 1
                self.last_move = now

    def mark(self, now: int) -> None:
        """Everything that is here may pass."""
        self.released.add(now, self.pushed.count - self.released.count)
        self.marks += 1

    def has_item(self, now: int) -> bool:
        return bool(self.ends) and self.ends[0] <= self.read.seen(now)

    def coming(self, now: int) -> Transfer | None:
        """The transfer under way that brings the first byte that is not here; None if it may not pass, or none is."""
        for transfers in (self.reading, self.writing):
            while transfers and transfers[0].is_over(now):
                transfers.popleft()
        here = self.read.seen(now)
        if self.released.seen(now) <= here:
            return None
        first = next((transfers[0] for transfers in (self.reading, self.writing) if transfers), None)
        return first if first is not None and first.begin <= here else None

    def take(self, now: int) -> None:
        self.taken.add(now, self.ends.popleft() - self.taken.count)
        self.stays.leave(now)
        self.num_taken += 1

    def is_stuck(self, now: int) -> bool:
        """Whether nothing was asked of the memory or released early in this cycle, and nothing is under way."""
        return self.last_move < now and not self.writes and not self.reads

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: after the units, in every cycle."""
        tick = 0
        while True:
            yield at(self.env, tick, Phase.ISSUE, self.index)
            self._write(tick)
            self._ask(tick)
            tick += self.period_ticks

    def _write(self, now: int) -> None:
        """Send a line that is full, or what is released of it."""
        line_end = self._line_end(self.sent)
        end = line_end if self.pushed.seen(now) >= line_end else self.released.seen(now)
        if end > self.sent and len(self.writes) < self.spec.outstanding:
            write = Transfer(self.sent, end)
            self.writes.append(write)
            self.writing.append(write)
            self._transfer(now, Kind.WRITE, write, self._write_done)
            self.sent = end
            self.num_writes += 1

    def _ask(self, now: int) -> None:
        """Ask for a line, or for what is released and written of it."""
        end = min(self._line_end(self.asked), self.released.seen(now), self.written)
        is_wanted = self.asked - self.taken.seen(now) < self.spec.prefetch_bytes
        if end > self.asked and is_wanted and len(self.reads) < self.spec.outstanding:
            read = Transfer(self.asked, end)
            self.reads.append(read)
            self.reading.append(read)
            self._transfer(now, Kind.READ, read, self._read_done)
            self.asked = end
            self.num_reads += 1

    def _line_end(self, offset: int) -> int:
        return (offset // self.spec.line_bytes + 1) * self.spec.line_bytes

    def _transfer(self, now: int, kind: Kind, transfer: Transfer, done: Callable[[int], None]) -> None:
        def answer(tick: int) -> None:
            transfer.is_done = True
            self.last_move = tick
            done(tick)

        self.last_move = now
        address = self.spec.base + transfer.begin % self.spec.ring_bytes
        self.send(now, kind, address, transfer.end - transfer.begin, answer, transfer.wait)

    def _write_done(self, now: int) -> None:
        while self.writes and self.writes[0].is_done:
            self.writes[0].came = now
            self.written = self.writes.popleft().end

    def _read_done(self, now: int) -> None:
        while self.reads and self.reads[0].is_done:
            self.reads[0].came = now
            self.read.add(now, self.reads.popleft().end - self.read.count)
