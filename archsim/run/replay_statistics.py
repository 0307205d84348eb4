"""The statistics of a replayed address trace that a phase does not have."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.machine.dram_alone.stream import DramRun
from archsim.model.cache.functional import LevelCounts
from archsim.model.dram.spec import DramSpec, Scheduler
from archsim.run.measure import Measure, measured, percent, ratio
from archsim.run.metrics import DRAM, DramView
from archsim.run.result import Statistic
from archsim.trace.accesses import Kind

TRACE = [
    Measure("accesses", "accesses", "Lines of the trace.", lambda kinds: kinds.sum()),
    Measure("reads", "accesses", "Those that read data.", lambda kinds: kinds[Kind.READ]),
    Measure("writes", "accesses", "Those that write.", lambda kinds: kinds[Kind.WRITE]),
    Measure("fetches", "accesses", "Those that fetch instructions.", lambda kinds: kinds[Kind.FETCH]),
]
"""Of the number of accesses by kind."""


def _accesses(level: LevelCounts) -> int:
    return level.reads + level.writes


def _misses(level: LevelCounts) -> int:
    return level.read_misses + level.write_misses


LEVEL = [
    Measure(
        "accesses",
        "lookups",
        "Lookups; a request that crosses lines is one for each.",
        _accesses,
    ),
    Measure("reads", "lookups", "Read lookups, instruction fetches included.", lambda level: level.reads),
    Measure(
        "writes",
        "lookups",
        "Write lookups: stores, and write-backs and written-through stores from above.",
        lambda level: level.writes,
    ),
    Measure(
        "hits",
        "lookups",
        "Lookups that found what they touch.",
        lambda level: _accesses(level) - _misses(level),
    ),
    Measure("misses", "lookups", "Lookups that did not find all they touch.", _misses),
    Measure("read_misses", "lookups", "Reads among the misses.", lambda level: level.read_misses),
    Measure("write_misses", "lookups", "Writes among the misses.", lambda level: level.write_misses),
    Measure("fetches", "requests", "Reads sent to the next level.", lambda level: level.fetches),
    Measure(
        "writebacks",
        "requests",
        "Runs of dirty sectors sent to the next level; a line without sectors is one run.",
        lambda level: level.writebacks,
    ),
    Measure(
        "writethroughs",
        "requests",
        "Writes sent to the next level as they came.",
        lambda level: level.writethroughs,
    ),
    Measure(
        "hit_percent",
        "%",
        "Hits over accesses.",
        lambda level: percent(_accesses(level) - _misses(level), _accesses(level)),
    ),
    Measure("bytes_read", "bytes", "Bytes of the fetches.", lambda level: level.bytes_read),
    Measure(
        "bytes_written",
        "bytes",
        "Bytes of write-backs and written-through writes.",
        lambda level: level.bytes_written,
    ),
]
"""Of the LevelCounts of a cache without time."""

MEMORY = [
    Measure("requests", "requests", "Requests of the last cache.", _accesses),
    Measure("reads", "requests", "Fetches of the last cache.", lambda level: level.reads),
    Measure("writes", "requests", "Writes of the last cache.", lambda level: level.writes),
]
"""Of the LevelCounts of the memory behind caches without time."""

REPLAY = [
    Measure(
        "cycles",
        "cycles",
        "Core cycles until the last access was answered.",
        lambda view: view[0].counters.cycles,
    ),
    Measure(
        "cycles_per_access",
        "cycles",
        "Cycles over accesses.",
        lambda view: ratio(view[0].counters.cycles, view[1].sum()),
    ),
]
"""Of a PhaseView and the number of accesses by kind."""


class Speed(NamedTuple):
    """What a DRAM moved, and in which time."""

    clocks: int  # memory clocks until the replay was over
    hertz: float  # of the memory clock
    moved_bytes: int
    peak_bytes: int  # that all data buses carry in a clock; 0 for an ideal DRAM, which has none


def _peak_bytes(spec: DramSpec) -> int:
    return 0 if spec.scheduler == Scheduler.IDEAL else spec.clock_beats * spec.beat_bytes * spec.num_channels


def speed_below_caches(view: DramView) -> Speed:
    """Of a replay with time on caches; it is over when nothing is on its way any more."""
    spec, hertz = view.phase.machine.spec, view.phase.machine.tick_hertz
    clocks = -(-view.phase.counters.drained_cycles * spec.core.period_ticks // spec.dram.period_ticks)
    return Speed(clocks, hertz / spec.dram.period_ticks, view.moved_bytes, _peak_bytes(spec.dram))


SPEED = [
    Measure(
        "cycles",
        "clocks",
        "Memory clocks until all that the accesses caused was over; of a DRAM alone, until the last data moved.",
        lambda speed: speed.clocks,
    ),
    Measure(
        "gigabytes_per_second",
        "GB/s",
        "Bytes carried by the data buses over the time of those cycles; 1 GB is 10^9 bytes.",
        lambda speed: ratio(speed.moved_bytes * speed.hertz, 1e9 * speed.clocks),
    ),
    Measure(
        "peak_gigabytes_per_second",
        "GB/s",
        "What all data buses carry if no clock is lost; 0 if the DRAM is ideal.",
        lambda speed: speed.peak_bytes * speed.hertz / 1e9,
    ),
    Measure(
        "peak_percent",
        "%",
        "Gigabytes a second over the peak.",
        lambda speed: percent(speed.moved_bytes, speed.peak_bytes * speed.clocks),
    ),
]
"""Of a Speed."""


class DramAloneView(NamedTuple):
    """A DRAM that a stream was given to."""

    run: DramRun
    spec: DramSpec

    def total(self, counter: str) -> int:
        """A counter's sum over the channels."""
        return int(self.run.counters[counter].sum())

    @property
    def moved_bytes(self) -> int:
        return self.total("data_clocks") * self.spec.clock_beats * self.spec.beat_bytes

    def speed(self, hertz: int) -> Speed:
        return Speed(self.run.clocks, hertz, self.moved_bytes, _peak_bytes(self.spec))

    def quantile(self, share: float) -> int:
        """The fewest clocks that this share of the reads did not exceed; 0 without reads."""
        counts = self.run.latencies
        found = int(np.searchsorted(np.cumsum(counts), share * counts.sum()))
        return min(found, self.run.latency_max) if counts.any() else 0


READ_TIMES = [
    Measure(
        "average_read_clocks",
        "clocks",
        "Memory clocks from a read's entry into the queue to its last data, averaged.",
        lambda view: view.run.mean_latency,
    ),
    Measure(
        "median_read_clocks",
        "clocks",
        "Memory clocks that half of the reads did not exceed.",
        lambda view: view.quantile(0.5),
    ),
    Measure(
        "p99_read_clocks",
        "clocks",
        "Memory clocks that 99 % of the reads did not exceed.",
        lambda view: view.quantile(0.99),
    ),
    Measure(
        "longest_read_clocks",
        "clocks",
        "Memory clocks that the longest read took.",
        lambda view: view.run.latency_max,
    ),
    Measure(
        "average_entry_clocks",
        "clocks",
        "Memory clocks from a request's cycle in the trace to its entry into the queue, averaged.",
        lambda view: ratio(view.run.wait_sum, view.run.num_requests),
    ),
]
"""Of a DramAloneView."""


_COUNTERS = (
    "reads",
    "writes",
    "forwarded",
    "row_hits",
    "row_misses",
    "row_conflicts",
    "activates",
    "precharges",
    "refreshes",
    "read_queue_clocks",
    "read_refresh_clocks",
    "read_activation_clocks",
    "read_turnaround_clocks",
    "read_bus_clocks",
)


def dram_alone(view: DramAloneView, hertz: int) -> list[Statistic]:
    """All statistics of a DRAM alone; its counters are called as in a phase, and `requests` counts all."""
    known = {measure.name: measure for measure in DRAM}
    values = {name: view.total(name) for name in _COUNTERS}
    values |= {"requests": view.run.num_requests, "bytes": view.moved_bytes}
    found = [Statistic(f"dram.{name}", value, *known[name][1:3]) for name, value in values.items()]
    return found + measured("dram", READ_TIMES, view) + measured("dram", SPEED, view.speed(hertz))
