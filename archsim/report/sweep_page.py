"""A sweep on a page: what moves its metrics, the Pareto front, every point."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from archsim.errors import ArchsimError
from archsim.report import sweep_figures
from archsim.report.page import render
from archsim.sweep.analysis import amounts, finding, finished, knee, pareto_front, sensitivity
from archsim.sweep.store import read_index
from archsim.sweep.table import load_table, metrics_of, parameters_of


def sweep_report(folder: Path) -> str:
    """The page of a sweep's folder as HTML text."""
    table, parameters = load_table(folder), parameters_of(folder)
    metrics, points = metrics_of(folder, table), finished(table)
    statistics = [metric for metric in metrics if metric not in parameters] if len(points) else []
    front = pareto_front(table, metrics) if len(points) else points
    columns = list(dict.fromkeys([*parameters, *metrics]))
    return render(
        "sweep.html.j2",
        title=read_index(folder).name,
        subtitle=f"A sweep of {len(table)} points over {len(parameters)} parameters",
        counts=table["status"].value_counts().to_dict(),
        metrics=metrics,
        sensitivities=[
            (metric, finding(points, parameters, metric), _records(sensitivity(table, parameters, metric)))
            for metric in statistics
        ],
        effects=[
            sweep_figures.effects(points, parameters, metric, f"effect{k}")
            for k, metric in enumerate(statistics)
        ],
        front_figure=_front_figure(points, front, metrics),
        front=_records(front[columns]) if len(front) else [],
        knee=knee(front, metrics),
        columns=columns,
        points=_records(table.reindex(columns=[*columns, "status"])),
        failures=_records(table[table["status"] == "failed"][["command", "error"]]),
    )


def _front_figure(points: pd.DataFrame, front: pd.DataFrame, metrics: list[str]) -> str:
    """The first two metrics against each other; nothing if there is only one."""
    if len(metrics) < 2 or not len(points):
        return ""
    try:
        all_points = [amounts(points, metric) for metric in metrics[:2]]
        best = [amounts(front, metric) for metric in metrics[:2]]
    except ArchsimError:
        return ""
    return sweep_figures.front(all_points, best, metrics[:2], "front")


def _records(frame: pd.DataFrame) -> list[dict[str, object]]:
    plain = frame.astype(object).where(frame.notna(), None)
    return [{str(key): value for key, value in row.items()} for row in plain.to_dict("records")]
