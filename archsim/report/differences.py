"""In what two runs differ: configuration, statistics by relative change, checks and picture."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from archsim.config.document import parse
from archsim.config.explain import flat
from archsim.errors import Location
from archsim.run.folder import StoredRun

MISSING = "-"


class ConfigChange(NamedTuple):
    """A key whose value differs; MISSING where it does not exist."""

    key: str
    left: Any
    right: Any


class StatisticChange(NamedTuple):
    """A statistic that differs; None where it does not exist."""

    name: str
    unit: str
    left: float | None
    right: float | None
    percent: float  # of the left value; infinite from 0 or from nothing


class Differences(NamedTuple):
    """Everything in which two runs differ."""

    config: list[ConfigChange]
    statistics: list[StatisticChange]  # the largest change first
    checks: list[tuple[str, bool | None, bool | None]]  # name, holds left, holds right
    num_pixels: int | None  # whose shadow differs; None: the pictures have different sizes, or there are none

    def matter(self, tolerance_percent: float = 0.0) -> bool:
        """Whether results differ; a configuration that differs without effect does not matter."""
        larger = any(abs(change.percent) > tolerance_percent for change in self.statistics)
        return larger or bool(self.checks) or self.num_pixels != 0


def differences(left: StoredRun, right: StoredRun) -> Differences:
    """Compare two stored runs."""
    return Differences(
        config_changes(left.config_yaml, right.config_yaml),
        _statistic_changes(left, right),
        _check_changes(left, right),
        _pixels(left.result.shadow, right.result.shadow),
    )


def config_changes(left: str, right: str) -> list[ConfigChange]:
    """Keys that differ between two resolved configurations, in the order of the text."""
    a, b = dict(flat(_tree(left))), dict(flat(_tree(right)))
    keys = dict.fromkeys([*a, *b])
    return [
        ConfigChange(key, a.get(key, MISSING), b.get(key, MISSING))
        for key in keys
        if a.get(key, MISSING) != b.get(key, MISSING)
    ]


def relative_percent(left: float | None, right: float | None) -> float:
    """Change from left to right in per cent of left."""
    if left is None or right is None:
        return math.inf
    if left == right or (left != left and right != right):
        return 0.0
    return 100.0 * (right - left) / abs(left) if left else math.copysign(math.inf, right)


def _tree(text: str) -> Any:
    return parse(text, lambda mark: Location("config.yaml", mark.line + 1), Path()).plain()


def _statistic_changes(left: StoredRun, right: StoredRun) -> list[StatisticChange]:
    a = {statistic.name: statistic for statistic in left.result.statistics}
    b = {statistic.name: statistic for statistic in right.result.statistics}
    changes = []
    for name in dict.fromkeys([*a, *b]):
        before = a[name].value if name in a else None
        after = b[name].value if name in b else None
        change = relative_percent(before, after)
        if change != 0:
            changes.append(StatisticChange(name, (a.get(name) or b[name]).unit, before, after, change))
    return sorted(changes, key=lambda change: -abs(change.percent))


def _check_changes(left: StoredRun, right: StoredRun) -> list[tuple[str, bool | None, bool | None]]:
    a = {check.name: check.ok for check in left.result.checks}
    b = {check.name: check.ok for check in right.result.checks}
    return [
        (name, a.get(name), b.get(name)) for name in dict.fromkeys([*a, *b]) if a.get(name) != b.get(name)
    ]


def _pixels(left: np.ndarray, right: np.ndarray) -> int | None:
    return int(np.count_nonzero(left != right)) if left.shape == right.shape else None
