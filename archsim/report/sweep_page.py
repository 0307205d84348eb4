"""A sweep on a page: what moves its metrics, the Pareto front, every point."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from archsim.errors import ArchsimError
from archsim.report import sweep_figures
from archsim.report.page import render
from archsim.run.folder import MANIFEST
from archsim.sweep.analysis import amounts, finding, finished, knee, pareto_front, sensitivity, short
from archsim.sweep.store import read_index
from archsim.sweep.table import load_table, metrics_of, parameters_of, units_of
from archsim.units import parse_bytes, parse_frequency

_OF_ONE_POINT = ("command", "config_digest", "scene_digest", "wall_seconds", "seed")  # in a manifest


class Card(NamedTuple):
    """The least of a metric."""

    value: Any
    unit: str
    label: str


def sweep_report(folder: Path) -> str:
    """The page of a sweep's folder as HTML text."""
    index, table, parameters = read_index(folder), load_table(folder), parameters_of(folder)
    metrics, points, units = metrics_of(folder, table), finished(table), units_of(folder)
    statistics = [metric for metric in metrics if metric not in parameters] if len(points) else []
    front = pareto_front(table, metrics)
    columns = list(dict.fromkeys([*parameters, *metrics]))
    return render(
        "sweep.html.j2",
        title=index.name,
        subtitle=f"A sweep of {len(table)} points over {len(parameters)} parameters",
        counts=table["status"].value_counts().to_dict(),
        cards=[
            Card(amounts(points, metric).min().item(), units.get(metric, ""), metric) for metric in statistics
        ],
        metrics=metrics,
        sensitivities=[
            (metric, finding(points, parameters, metric), _records(sensitivity(table, parameters, metric)))
            for metric in statistics
        ],
        effects=[
            sweep_figures.effects(points, parameters, metric, (_labelled(metric, units), f"effect{k}"))
            for k, metric in enumerate(statistics)
        ],
        front_figure=_front_figure(points, front, metrics, units),
        front=_records(front[columns]) if len(front) else [],
        knee=knee(front, metrics),
        columns=columns,
        units=units,
        points=_records(table.reindex(columns=[*columns, "status"])),
        failures=_records(table[table["status"] == "failed"][["command", "error"]]),
        set_by_sweep=index.set_by_sweep,
        of_run=index.of_run,
        commands=[entry.command for entry in index.points],
        manifest=_manifest(folder, points),
    )


def _labelled(name: str, units: dict[str, str]) -> str:
    """A column with its unit."""
    return f"{short(name)} [{units[name]}]" if units.get(name) else short(name)


def _manifest(folder: Path, points: pd.DataFrame) -> dict[str, Any]:
    """What the finished points were made with, and how long they took; empty without any."""
    if not len(points):
        return {}
    first = folder / "points" / points["point"][0] / MANIFEST
    whole = json.loads(first.read_text(encoding="utf-8"))
    common = {key: value for key, value in whole.items() if key not in _OF_ONE_POINT}
    return common | {"seconds of all points together": round(float(points["seconds"].sum()), 3)}


def _front_figure(
    points: pd.DataFrame, front: pd.DataFrame, metrics: list[str], units: dict[str, str]
) -> str:
    """The first two metrics against each other; nothing if there is only one."""
    if len(metrics) < 2 or not len(points):
        return ""
    try:
        all_points = [amounts(points, metric) for metric in metrics[:2]]
        best = [amounts(front, metric) for metric in metrics[:2]]
    except ArchsimError:
        return ""
    known = {metric: _quantity(front[metric][0]) for metric in metrics[:2]} | units
    return sweep_figures.front(
        all_points, best, [_labelled(metric, known) for metric in metrics[:2]], "front"
    )


def _quantity(value: Any) -> str:
    """The unit in which a size or frequency is drawn; nothing for others."""
    for parse, unit in ((parse_bytes, "B"), (parse_frequency, "Hz")):
        try:
            if isinstance(value, str) and parse(value):
                return unit
        except ArchsimError:
            continue
    return ""


def _records(frame: pd.DataFrame) -> list[dict[str, object]]:
    plain = frame.astype(object).where(frame.notna(), None)
    return [{str(key): value for key, value in row.items()} for row in plain.to_dict("records")]
