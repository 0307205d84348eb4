"""How a phase went over time: ratios of every interval, from what the machine tells at its ends."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from archsim.machine.build import PhaseMachine
from archsim.machine.counters import Counters
from archsim.machine.series import Sample, Sampling, sample_of
from archsim.run.measure import Measure, percent, ratio
from archsim.run.result import Series

MOST_INTERVALS = 1000  # of a series; when there would be more, each two become one


class Interval(NamedTuple):
    """What happened between two samples."""

    machine: PhaseMachine
    begin: Sample
    end: Sample

    def grown(self, name: str) -> Any:
        """By how much a count grew."""
        return getattr(self.end, name) - getattr(self.begin, name)

    @property
    def moved_bytes(self) -> int:
        dram = self.machine.spec.dram
        return int(self.grown("data_clocks")) * dram.clock_beats * dram.beat_bytes

    @property
    def clocks(self) -> float:
        """Memory clocks."""
        spec = self.machine.spec
        return float(self.grown("cycle")) * spec.core.period_ticks / spec.dram.period_ticks

    def of_caches(self, name: str, cache: str) -> int:
        """By how much a count of the caches of that name grew."""
        members = [k for k, other in enumerate(self.machine.cache_names) if other == cache]
        return int(self.grown(name)[members].sum())


INTERVALS = [
    Measure(
        "until_cycle", "cycles", "The core cycle before which the interval ends.", lambda part: part.end.cycle
    ),
    Measure(
        "useful_percent",
        "%",
        "Share of its issue slots that were used.",
        lambda part: percent(part.grown("useful"), part.grown("cycle") * part.machine.spec.core.num_cores),
    ),
    Measure(
        "dram.bandwidth_bytes_per_cycle",
        "bytes/cycle",
        "Bytes that the DRAM moved over its core cycles, each at the column command.",
        lambda part: ratio(part.moved_bytes, part.grown("cycle")),
    ),
    Measure(
        "dram.row_hit_percent",
        "%",
        "Row hits over the requests first considered in it.",
        lambda part: percent(part.grown("row_hits"), part.grown("classified")),
    ),
    Measure(
        "dram.queue_depth",
        "requests",
        "Clocks that the requests served in it had waited, over its memory clocks: the mean length of all queues.",
        lambda part: ratio(part.grown("waited_clocks"), part.clocks),
    ),
]


def hit_percents(part: Interval) -> dict[str, float]:
    """Hits over lookups for every cache by name."""
    return {
        f"{cache}.hit_percent": percent(part.of_caches("hits", cache), part.of_caches("lookups", cache))
        for cache in dict.fromkeys(part.machine.cache_names)
    }


class Recorder:
    """Takes the samples of one phase."""

    def __init__(self, interval_cycles: int):
        self.sampling = Sampling(interval_cycles, self.take)
        self.interval_cycles = interval_cycles
        self.samples: list[Sample] = []

    def take(self, sample: Sample) -> None:
        """Keep a sample; double the interval when there are many."""
        if sample.cycle % self.interval_cycles == 0:
            self.samples.append(sample)
        if len(self.samples) == MOST_INTERVALS:
            self.samples = self.samples[1::2]
            self.interval_cycles *= 2

    def series(self, machine: PhaseMachine, counters: Counters) -> Series:
        """The phase over time, with what remained at its end as the last interval."""
        nothing = np.zeros(len(machine.cache_names), np.int64)
        ends = [*self.samples, sample_of(counters.drained_cycles + 1, counters)]
        begins = [Sample(0, 0, nothing, nothing, 0, 0, 0, 0), *self.samples]
        columns: dict[str, list[float]] = {}
        for begin, end in zip(begins, ends, strict=True):
            part = Interval(machine, begin, end)
            values = {measure.name: float(measure.value(part)) for measure in INTERVALS}
            for name, value in {**values, **hit_percents(part)}.items():
                columns.setdefault(name, []).append(round(value, 4))
        return Series(self.interval_cycles, columns)
