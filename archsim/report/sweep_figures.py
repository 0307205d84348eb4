"""The figures of a sweep: main effects of its parameters, and its Pareto front."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from archsim.report.figures import BLUE, GREY, STYLED, VERMILLION, as_svg
from archsim.sweep.analysis import amounts


@STYLED
def effects(points: pd.DataFrame, parameters: Sequence[str], metric: str, key: str) -> str:
    """For each parameter the metric of every point and its mean over the points that share a value."""
    figure = Figure(figsize=(11.4, 3.2), layout="constrained")
    axes = figure.subplots(1, max(len(parameters), 1), sharey=True, squeeze=False)[0]
    values = amounts(points, metric)
    for axis, name in zip(axes, parameters, strict=False):
        labels = points[name].map(str).to_numpy()
        order = list(dict.fromkeys(labels))
        place = np.array([order.index(label) for label in labels])
        axis.plot(place, values, "o", color=GREY, markersize=4)
        means = [values[labels == label].mean() for label in order]
        axis.plot(range(len(order)), means, "-o", color=BLUE, markersize=5)
        axis.set_xticks(range(len(order)), order, rotation=30 if len(order) > 4 else 0)
        axis.set_xlabel(_short(name))
    axes[0].set_ylabel(metric)
    return as_svg(figure, key)


@STYLED
def front(points: Sequence[np.ndarray], best: Sequence[np.ndarray], names: Sequence[str], key: str) -> str:
    """All points, and the front that no point beats, in two columns."""
    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.plot(points[0], points[1], "o", color=GREY, markersize=5, label="points")
    axes.plot(best[0], best[1], "-o", color=VERMILLION, markersize=6, label="Pareto front")
    axes.set(xlabel=names[0], ylabel=names[1])
    axes.legend(frameon=False)
    return as_svg(figure, key)


def _short(name: str) -> str:
    return name if len(name) <= 34 else "..." + name[-31:]
