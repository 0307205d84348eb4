"""The figures of a sweep: main effects of its parameters, and its Pareto front."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from archsim.report.figures import BLUE, GREY, STYLED, VERMILLION, as_svg
from archsim.sweep.analysis import amounts, in_order, short, texts

_IN_A_ROW = 3


@STYLED
def effects(points: pd.DataFrame, parameters: Sequence[str], metric: str, labels: tuple[str, str]) -> str:
    """For each parameter the metric of every point and its mean over the points that share a value.

    `labels`: the metric's axis, and the key of the figure.
    """
    rows, columns = -(-len(parameters) // _IN_A_ROW) or 1, max(1, min(len(parameters), _IN_A_ROW))
    figure = Figure(figsize=(11.4, 3.2 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
    points = points[points[metric].notna()]
    values = amounts(points, metric)
    for axes, name in zip(panels.ravel(), parameters, strict=False):
        _effect(axes, values, texts(points, name), in_order(points, name))
        axes.set_xlabel(short(name))
    for axes in panels.ravel()[len(parameters) :]:
        axes.set_visible(False)
    for axes in panels[:, 0]:
        axes.set_ylabel(labels[0])
        axes.yaxis.set_major_formatter("{x:,.10g}")
    return as_svg(figure, labels[1])


def _effect(axes: Axes, values: np.ndarray, own: np.ndarray, order: list[str]) -> None:
    """The values of points over the texts of their parameter, and the means."""
    place = np.array([order.index(text) for text in own])
    axes.plot(place, values, "o", color=GREY, markersize=4)
    means = [values[own == text].mean() for text in order]
    axes.plot(range(len(order)), means, "-o", color=BLUE, markersize=5)
    slanted = sum(len(text) for text in order) > 30
    axes.set_xticks(
        range(len(order)), order, rotation=30 if slanted else 0, ha="right" if slanted else "center"
    )


@STYLED
def front(points: Sequence[np.ndarray], best: Sequence[np.ndarray], names: Sequence[str], key: str) -> str:
    """All points, and the front that no point beats, in two columns."""
    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.plot(points[0], points[1], "o", color=GREY, markersize=5, label="points")
    axes.plot(best[0], best[1], "-o", color=VERMILLION, markersize=6, label="Pareto front")
    axes.set(xlabel=names[0], ylabel=names[1])
    axes.xaxis.set_major_formatter("{x:,.10g}")
    axes.yaxis.set_major_formatter("{x:,.10g}")
    axes.legend(frameon=False)
    return as_svg(figure, key)
