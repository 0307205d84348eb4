"""What a sweep says: which points no other point beats, which of them is the knee, which parameter matters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from archsim.errors import ArchsimError, did_you_mean, fail
from archsim.units import parse_bytes, parse_frequency

AS_IN_THE_RUN = "as in the run"


def finished(table: pd.DataFrame) -> pd.DataFrame:
    """The points that have a result."""
    return table[table["status"] == "finished"].reset_index(drop=True)


def amounts(table: pd.DataFrame, column: str) -> np.ndarray:
    """float64 [rows] of a column; sizes and frequencies in their plain units. ArchsimError if it has none."""
    if column not in table.columns:
        near = did_you_mean(column, [str(name) for name in table.columns])
        raise fail(f"the table has no column '{column}'", hint=near)
    return np.array([_amount(column, value) for value in table[column]], np.float64)


def pareto_front(table: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """The finished points that no other point equals or beats in all columns and beats in one; less is better."""
    points = finished(table)
    if not len(points) or not columns:
        return points.head(0)
    values = np.stack([amounts(points, column) for column in columns], axis=1)
    beaten = [bool(((values <= own).all(axis=1) & (values < own).any(axis=1)).any()) for own in values]
    front = points[~np.array(beaten, np.bool_)]
    return front.sort_values(columns[0], key=lambda _: amounts(front, columns[0])).reset_index(drop=True)


def knee(front: pd.DataFrame, columns: Sequence[str]) -> int | None:
    """Row of the front that is nearest to the best of every column, each scaled from its best 0 to its worst 1."""
    if not len(front):
        return None
    values = np.stack([amounts(front, column) for column in columns], axis=1)
    spread = values.max(axis=0) - values.min(axis=0)
    scaled = (values - values.min(axis=0)) / np.where(spread > 0, spread, 1.0)
    return int(np.argmin(np.hypot.reduce(scaled, axis=1)))


def sensitivity(table: pd.DataFrame, parameters: Sequence[str], metric: str) -> pd.DataFrame:
    """How much each parameter moves a metric, the strongest first.

    `range_percent`: from the lowest to the highest mean over the points that share a value, over the mean of all.
    `explained_percent`: share of the metric's variance that these means have.
    """
    points = finished(table)
    if metric in points.columns:
        points = points[points[metric].notna()]
    values = amounts(points, metric)
    rows = []
    for name in parameters:
        keys = texts(points, name)
        means = {key: values[keys == key].mean() for key in dict.fromkeys(keys)}
        spread = max(means.values()) - min(means.values()) if means else 0.0
        between = np.array([means[key] for key in keys]).var() if len(values) else 0.0
        total = values.var() if len(values) else 0.0
        rows.append(
            {
                "parameter": name,
                "range_percent": 100.0 * spread / abs(values.mean())
                if len(values) and values.mean()
                else 0.0,
                "explained_percent": 100.0 * between / total if total else 0.0,
                "best": min(means, key=lambda key: means[key]) if means else None,
            }
        )
    found = pd.DataFrame(rows, columns=["parameter", "range_percent", "explained_percent", "best"])
    return found.sort_values("range_percent", ascending=False, kind="stable").reset_index(drop=True)


def finding(table: pd.DataFrame, parameters: Sequence[str], metric: str) -> str:
    """What a sweep found about a metric: where it is least and most, and what moves it of what all points have."""
    points, own = finished(table), _different(table, parameters)
    if metric in points.columns:
        points = points[points[metric].notna()].reset_index(drop=True)
    values = amounts(points, metric)
    if len(values) < 2 or not own:
        return f"{metric}: one point says nothing."
    least, most = int(values.argmin()), int(values.argmax())
    if values[least] == values[most]:
        return f"{metric} is {values[least]:,.10g} at all {len(values)} points."
    more = f" (+{100 * (values[most] / values[least] - 1):.3g} %)" if values[least] > 0 else ""
    effects = sensitivity(table, [name for name in own if points[name].notna().all()], metric)
    moves = [
        f"{effects['range_percent'][row]:.3g} % over {short(str(effects['parameter'][row]))}"
        for row in range(len(effects))
    ]
    return (
        f"{metric} is least, {values[least]:,.10g}, with {_where(points, own, least)}; "
        f"most, {values[most]:,.10g}{more}, with {_where(points, own, most)}."
        + (f" Its means differ by {', '.join(moves)}." if moves else "")
    )


def _different(table: pd.DataFrame, parameters: Sequence[str]) -> list[str]:
    """The parameters but those that always go with an earlier one."""
    kept: dict[tuple[int, ...], str] = {}
    for name in parameters:
        kept.setdefault(tuple(pd.factorize(table[name].map(str))[0]), name)
    return list(kept.values())


def _where(points: pd.DataFrame, parameters: Sequence[str], row: int) -> str:
    """The values of a point, of the parameters that it has."""
    has = [(short(name), points[name][row]) for name in parameters if not pd.isna(points[name][row])]
    return ", ".join(
        f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}" for name, value in has
    )


def short(parameter: str) -> str:
    """The path without the part that most parameters share."""
    return parameter.removeprefix("machine.components.").removeprefix("workload.")


def texts(points: pd.DataFrame, parameter: str) -> np.ndarray:
    """str [rows] of a parameter's values; what a point does not set is as in the sweep's run."""
    return np.array([AS_IN_THE_RUN if pd.isna(value) else str(value) for value in points[parameter]], object)


def in_order(points: pd.DataFrame, parameter: str) -> list[str]:
    """The different texts of a parameter's values: by their amounts where they have any, else as they come."""
    found = dict(zip(texts(points, parameter), points[parameter], strict=True))
    try:
        return sorted(found, key=lambda text: -np.inf if text == AS_IN_THE_RUN else _amount("", found[text]))
    except ArchsimError:
        return list(found)


def _amount(column: str, value: Any) -> float:
    if isinstance(value, int | float | np.integer | np.floating):
        return float(value)
    for parse in (parse_bytes, parse_frequency):
        try:
            return float(parse(value))
        except (ArchsimError, TypeError):
            continue
    raise fail(f"'{column}' holds {value!r}, which is not a number: it cannot be compared")
