"""A DRAM fed with a stream, to be believed: one more SimPy process, which lets requests enter at every clock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterable, Iterator

import numpy as np
import simpy

from archsim.machine.dram_alone.stream import LONGEST_LATENCY, DramRun, Requests, bursts_of, check
from archsim.model.cache.reference import Kind, Request
from archsim.model.dram.commands import COMMAND, DRAM_COUNTERS, CommandSink
from archsim.model.dram.reference import Dram
from archsim.model.dram.spec import DramSpec
from archsim.model.reference import Phase, at
from archsim.model.waiting import Wait


def simulate(
    spec: DramSpec, request_bytes: int, chunks: Iterable[Requests], sink: CommandSink | None = None
) -> DramRun:
    """Serve the stream; the commands go to `sink`. ArchsimError for requests that can't be served."""
    bursts_of(spec, request_bytes)
    feeder = Feeder(spec, request_bytes, _one_by_one(chunks))
    commands: list[tuple[int, ...]] = []
    feeder.dram.record(commands)
    for channel in feeder.dram.channels:
        feeder.env.process(channel.run())
    feeder.env.run(until=feeder.env.process(feeder.run()))
    if sink is not None:
        sink(np.array(commands, COMMAND))
    return feeder.outcome()


def _one_by_one(chunks: Iterable[Requests]) -> Iterator[tuple[int, bool, int]]:
    previous_arrival = 0
    for requests in chunks:
        check(requests, previous_arrival)
        yield from zip(*(column.tolist() for column in requests), strict=True)
        previous_arrival = int(requests.arrivals[-1]) if len(requests.arrivals) else previous_arrival


class Feeder:
    """Lets requests enter, and notes when reads are answered."""

    def __init__(self, spec: DramSpec, request_bytes: int, stream: Iterator[tuple[int, bool, int]]):
        self.spec, self.request_bytes, self.stream = spec, request_bytes, stream
        self.env = simpy.Environment()
        self.dram = Dram(spec, self.env, 0, spec.period_ticks)
        self.next = next(stream, None)
        self.num_waiting_reads = self.wait_sum = self.last_answer = 0
        self.latencies: Counter[int] = Counter()

    def run(self) -> Generator[simpy.Event, None, None]:
        clock = 0
        while self.next is not None or self.num_waiting_reads > 0 or not self.dram.is_quiet():
            yield at(self.env, clock * self.spec.period_ticks, Phase.ARRIVE)
            self._enter(clock)
            yield at(self.env, clock * self.spec.period_ticks, Phase.END)
            clock += 1

    def _enter(self, clock: int) -> None:
        while self.next is not None:
            address, is_write, arrival = self.next
            channel = self.dram.channel_of(address)
            if arrival > clock or not channel.has_room(is_write):
                return
            self.wait_sum += clock - arrival
            if is_write:
                channel.arrive(Request(Kind.WRITEBACK, address, self.request_bytes, None, Wait()))
            else:
                self._read(clock, address)
            self.next = next(self.stream, None)

    def _read(self, clock: int, address: int) -> None:
        def answered(tick: int) -> None:
            self.num_waiting_reads -= 1
            self.last_answer = max(self.last_answer, tick // self.spec.period_ticks)
            self.latencies[tick // self.spec.period_ticks - clock] += 1

        self.num_waiting_reads += 1
        self.dram.arrive(Request(Kind.READ, address, self.request_bytes, answered, Wait()))

    def outcome(self) -> DramRun:
        channels = self.dram.channels
        latencies = np.zeros(LONGEST_LATENCY + 1, np.int64)
        for latency, count in self.latencies.items():
            latencies[min(latency, LONGEST_LATENCY)] += count
        return DramRun(
            clocks=max([self.last_answer, *(channel.data_end for channel in channels)]),
            counters={
                name: np.array([channel.counts[name] for channel in channels], np.int64)
                for name in DRAM_COUNTERS
            },
            latencies=latencies,
            latency_sum=sum(latency * count for latency, count in self.latencies.items()),
            latency_max=max(self.latencies, default=0),
            wait_sum=self.wait_sum,
        )
