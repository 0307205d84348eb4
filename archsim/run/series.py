"""How a phase went over time: ratios of every interval, from what the machine tells at its ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from archsim.machine.build import PhaseMachine
from archsim.machine.heard import Heard
from archsim.machine.pipeline.build import PipelineMachine
from archsim.machine.series import Sample, Sampling
from archsim.run.listen import Listen
from archsim.run.measure import Measure, percent, ratio
from archsim.run.pipeline_metrics import without_cores
from archsim.run.result import Result, Series

MOST_INTERVALS = 1000  # of a series; when there would be more, each two become one


class Interval(NamedTuple):
    """What happened between two samples in a machine, or in one of its components."""

    machine: PhaseMachine | PipelineMachine
    begin: Sample
    end: Sample
    component: str = ""

    @property
    def memory(self) -> PhaseMachine:
        """The machine as one of caches and a DRAM."""
        return without_cores(self.machine) if isinstance(self.machine, PipelineMachine) else self.machine

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
        spec = self.memory.spec
        return float(self.grown("cycle")) * spec.core.period_ticks / spec.dram.period_ticks

    def of_caches(self, name: str) -> int:
        """By how much a count of the caches of the component's name grew."""
        members = [k for k, other in enumerate(self.memory.cache_names) if other == self.component]
        return int(self.grown(name)[members].sum())

    @property
    def busy_percent(self) -> float:
        """Of the cycles of the unit that the component is."""
        assert isinstance(self.machine, PipelineMachine)
        number = self.machine.units.index(self.component)
        return percent(self.grown("busy")[number], self.grown("cycle"))

    @property
    def fill_percent(self) -> float:
        """Of the room of the fifo or delay stream that the component is."""
        assert isinstance(self.machine, PipelineMachine)
        number = self.machine.channels.index(self.component)
        room = self.machine.spec.capacity(number)
        return percent(self.grown("stayed")[number], self.grown("cycle") * room)


def _share(part: int, whole: int) -> float:
    """Per cent; NaN, a gap in the figure, when there is no whole: no requests is not the same as none that hit."""
    return percent(part, whole) if whole else math.nan


INTERVALS = [
    Measure(
        "until_cycle", "cycles", "The cycle before which the interval ends.", lambda part: part.end.cycle
    ),
    Measure(
        "dram.bandwidth_bytes_per_cycle",
        "bytes/cycle",
        "Bytes that the DRAM moved over the cycles of cores or units, each at the column command.",
        lambda part: ratio(part.moved_bytes, part.grown("cycle")),
    ),
    Measure(
        "dram.row_hit_percent",
        "%",
        "Row hits over the requests first considered in it; null if there were none.",
        lambda part: _share(part.grown("row_hits"), part.grown("classified")),
    ),
    Measure(
        "dram.queue_depth",
        "requests",
        "Clocks that the requests served in it had waited, over its memory clocks: the mean length of all queues.",
        lambda part: ratio(part.grown("waited_clocks"), part.clocks),
    ),
]

OF_CORES = [
    Measure(
        "useful_percent",
        "%",
        "Share of its issue slots that were used.",
        lambda part: percent(part.grown("busy").sum(), part.grown("cycle") * len(part.end.busy)),
    ),
]

OF_CACHES = [
    Measure(
        "hit_percent",
        "%",
        "Hits over the lookups in it; null if there were none.",
        lambda part: _share(part.of_caches("hits"), part.of_caches("lookups")),
    ),
]

OF_UNITS = [
    Measure(
        "busy_percent", "%", "Share of its cycles in which the unit was busy.", lambda part: part.busy_percent
    ),
]

OF_CHANNELS = [
    Measure(
        "fill_percent",
        "%",
        "Share of the fifo's entries, or of the delay stream's bytes, that was held, mean over its cycles.",
        lambda part: part.fill_percent,
    ),
]


def _columns(part: Interval) -> dict[str, float]:
    """Every value of an interval by name."""
    of_all, components = INTERVALS, [(OF_CACHES, tuple(dict.fromkeys(part.memory.cache_names)))]
    if isinstance(part.machine, PipelineMachine):
        components += [(OF_UNITS, part.machine.units), (OF_CHANNELS, part.machine.channels)]
    else:
        of_all = [*INTERVALS, *OF_CORES]
    values = {measure.name: measure.value(part) for measure in of_all}
    for table, names in components:
        for name in names:
            own = part._replace(component=name)
            values |= {f"{name}.{measure.name}": measure.value(own) for measure in table}
    return {name: round(float(value), 4) for name, value in values.items()}


class Recorder:
    """Takes the samples of one phase; those of a playing follow those of the one before."""

    def __init__(self, interval_cycles: int, machine: PhaseMachine | PipelineMachine):
        self.interval_cycles, self.machine = interval_cycles, machine
        self.samples: list[Sample] = []
        self.before: Sample | None = None  # the last one of the playings before
        self.latest: Sample | None = None

    def begin(self) -> Sampling:
        """For one more playing."""
        self._keep_latest()
        self.before = self.latest
        return Sampling(self.interval_cycles, self.take)

    def take(self, sample: Sample) -> None:
        """Keep a sample of the playing, if it is one of an interval."""
        self.latest = sample if self.before is None else _behind(self.before, sample)
        if sample.cycle % self.interval_cycles == 0:
            self._keep_latest()

    def _keep_latest(self) -> None:
        """Unless it is kept; double the interval when there are many."""
        if self.latest is None or (self.samples and self.samples[-1] is self.latest):
            return
        self.samples.append(self.latest)
        if len(self.samples) == MOST_INTERVALS:
            self.samples = self.samples[1::2]
            self.interval_cycles *= 2

    def series(self) -> Series:
        """The phase over time, with what remained at its end as the last interval."""
        self._keep_latest()
        columns: dict[str, list[float]] = {}
        for begin, end in zip([_nothing(self.samples[0]), *self.samples], self.samples, strict=False):
            for name, value in _columns(Interval(self.machine, begin, end)).items():
                columns.setdefault(name, []).append(value)
        return Series(self.interval_cycles, columns)


def _behind(before: Iterable[Any], sample: Iterable[Any]) -> Sample:
    """A sample of a playing that began when another was over."""
    counts: list[Any] = [a + b for a, b in zip(before, sample, strict=True)]
    return Sample(*counts)


def _nothing(sample: Sample) -> Sample:
    """The sample of before the start."""
    counts: list[Any] = [0 * count for count in sample]
    return Sample(*counts)


def over_time(interval_cycles: int | None, listen: Listen, play: Callable[[Listen], Result]) -> Result:
    """The result of playing with somebody who listens; with the series of its phases, if they are wanted."""
    if interval_cycles is None:
        return play(listen)
    recorders: dict[str, Recorder] = {}

    def hear(phase: str, machine: PhaseMachine | PipelineMachine) -> Heard:
        recorder = recorders.setdefault(phase, Recorder(interval_cycles, machine))
        return listen(phase, machine)._replace(sampling=recorder.begin())

    result = play(hear)
    return result._replace(series={phase: recorder.series() for phase, recorder in recorders.items()})
