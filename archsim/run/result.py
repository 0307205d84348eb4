"""What a run returns, whatever it simulated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np


class Statistic(NamedTuple):
    """One number with its unit and the sentence that defines it."""

    name: str  # dotted, e.g. izb_build.l2.misses
    value: int | float
    unit: str
    description: str


class Check(NamedTuple):
    """A law that must hold in every run."""

    name: str
    ok: bool
    detail: str


class Histogram(NamedTuple):
    """How often each value occurred: counts[k] for the value k."""

    title: str
    unit: str  # of the values
    counted: str  # what has such a value: pixels, say
    counts: np.ndarray  # int64 [largest value + 1]


class Series(NamedTuple):
    """A phase over time; run/series.py says what its columns are."""

    interval_cycles: int  # of every interval, but the last ones of the phase's playings
    columns: dict[str, list[float]]  # name -> a value for each interval; NaN where there is none


class Result(NamedTuple):
    """A finished run."""

    name: str
    scene_digest: str  # of the scene that was simulated
    summary: dict[str, Any]  # plain JSON values: the few numbers a person asks for first
    statistics: list[Statistic]
    checks: list[Check]
    shadow: np.ndarray  # bool [height, width], row 0 at the top, True in shadow
    histograms: list[Histogram]
    maps: dict[str, np.ndarray]  # title [unit] -> float32 image, NaN where there is nothing to show
    latencies: Mapping[str, np.ndarray] = {}  # phase.level -> requests answered there, by class
    series: Mapping[str, Series] = {}  # phase -> how it went over time, if that was asked for

    def value(self, name: str) -> int | float:
        """The statistic of that name; KeyError if there is none."""
        return {statistic.name: statistic.value for statistic in self.statistics}[name]

    @property
    def ok(self) -> bool:
        return all(check.ok for check in self.checks)
