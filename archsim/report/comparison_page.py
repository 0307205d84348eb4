"""Several runs side by side: what was configured differently, what came of it, where the time went, what is seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from archsim.report import figures
from archsim.report.differences import MISSING, config_changes, relative_percent
from archsim.report.formats import setting
from archsim.report.page import png_uri, render, shadow_caption, shadow_uri
from archsim.report.statistics import phases
from archsim.run.folder import StoredRun

_DIFFERENT, _EQUAL = (213, 94, 0), (238, 238, 238)  # RGB


class Row(NamedTuple):
    """A line of a table: a value for each run."""

    name: str
    unit: str
    values: list[Any]
    changes: list[float | None]  # per cent of the first run's value


def comparison_report(runs: Sequence[StoredRun]) -> str:
    """The page as HTML text; every run is compared with the first."""
    names = _names(runs)
    ran = {
        f"{name}: {phase.name}": phase
        for name, run in zip(names, runs, strict=True)
        for phase in phases(run.result)
    }
    statistics = _statistics(runs)
    known = {row.name: row for row in statistics}
    return render(
        "comparison.html.j2",
        title=" / ".join(names),
        subtitle=f"{len(runs)} runs; the first, {names[0]}, is the baseline of every per cent",
        names=names,
        headlines=[known[name] for name in runs[0].result.summary if name in known],
        config=_config(runs),
        stalls=figures.stall_stack(ran) if ran else "",
        statistics=[row for row in statistics if any(row.changes)],
        num_equal=sum(not any(row.changes) for row in statistics),
        shadows=_pictures(names, runs),
        manifests=list(zip(names, (run.manifest for run in runs), strict=True)),
    )


def _names(runs: Sequence[StoredRun]) -> list[str]:
    """A name for each run: its own where they differ, else its folder."""
    own = [run.result.name for run in runs]
    return own if len(set(own)) == len(own) else [str(run.path) for run in runs]


def _config(runs: Sequence[StoredRun]) -> list[Row]:
    """Keys that differ in any run from the first."""
    changes = [{c.key: c for c in config_changes(runs[0].config_yaml, run.config_yaml)} for run in runs[1:]]
    keys = dict.fromkeys(key for found in changes for key in found)
    rows = []
    for key in keys:
        first = next(found[key].left for found in changes if key in found)
        others = [found[key].right if key in found else first for found in changes]
        values = ["not there" if value == MISSING else setting(value) for value in (first, *others)]
        rows.append(Row(key, "", values, []))
    return rows


def _statistics(runs: Sequence[StoredRun]) -> list[Row]:
    """All statistics, the largest change first."""
    values = [{s.name: s for s in run.result.statistics} for run in runs]
    rows = []
    for name in dict.fromkeys(name for own in values for name in own):
        statistics = [own.get(name) for own in values]
        unit = next(statistic.unit for statistic in statistics if statistic is not None)
        numbers = [None if statistic is None else statistic.value for statistic in statistics]
        changes = [None, *(relative_percent(numbers[0], number) for number in numbers[1:])]
        rows.append(Row(name, unit, numbers, changes))
    return sorted(rows, key=lambda row: -max(abs(change or 0.0) for change in row.changes))


def _pictures(names: Sequence[str], runs: Sequence[StoredRun]) -> list[tuple[str, str]]:
    """(caption, data URI): every mask, and behind it where it differs from the first."""
    first = runs[0].result.shadow
    pictures = []
    for name, run in zip(names, runs, strict=True):
        mask = run.result.shadow
        if not mask.size:
            continue
        pictures.append((f"{name}: {shadow_caption(mask)}", shadow_uri(mask)))
        differs = mask != first if mask.shape == first.shape else np.zeros(0, np.bool_)
        if differs.any():
            colours = np.where(differs[..., None], np.array(_DIFFERENT, np.uint8), np.array(_EQUAL, np.uint8))
            caption = f"{name}: {int(differs.sum())} pixels differ from {names[0]}."
            pictures.append((caption, png_uri(colours)))
    return pictures
