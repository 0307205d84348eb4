"""Figures of how a phase went over time, and of how long its requests took, as inline SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from archsim.model.latency import NUM_CLASSES, shortest
from archsim.report.figures import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    STYLED,
    VERMILLION,
    as_svg,
    plain_ticks,
)
from archsim.report.formats import words
from archsim.run.result import Series

_BANDS = ("busy_percent", "fill_percent")  # ratios of which many components have one


@STYLED
def series_plot(title: str, series: Series, key: str) -> str:
    """What a phase did over time: a panel for each ratio; one of coloured bands for those of many components."""
    columns = {name: values for name, values in series.columns.items() if name != "until_cycle"}
    bands = {band: [name for name in columns if name.endswith(f".{band}")] for band in _BANDS}
    bands = {band: names for band, names in bands.items() if names}
    lines = [name for name in columns if not any(name in names for names in bands.values())]
    heights = [1.2] * len(lines) + [0.4 + 0.22 * len(names) for names in bands.values()]
    figure = Figure(figsize=(11.4, 0.7 + sum(heights)), layout="constrained")
    panels = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    edges = np.array([0.0, *series.columns["until_cycle"]])
    colours = (GREEN, VERMILLION, BLUE, ORANGE, SKY, PURPLE) * 9
    for axes, name, colour in zip(panels, lines, colours, strict=False):
        axes.stairs(columns[name], edges, baseline=None, color=colour, linewidth=1.2)
        axes.set_ylabel(words(name.replace(".", "\n").replace("_bytes", "\nbytes")), fontsize=8)
        axes.set_ylim(bottom=0)
    for axes, (band, names) in zip(panels[len(lines) :], bands.items(), strict=True):
        _bands(axes, edges, {name.removesuffix(f".{band}"): columns[name] for name in names})
        axes.set_ylabel(words(band), fontsize=8)
    panels[0].set_title(title)
    panels[-1].set_xlabel(f"cycle, in intervals of {series.interval_cycles:,}")
    panels[-1].set_xlim(0, edges[-1])
    panels[-1].xaxis.set_major_formatter("{x:,.0f}")
    return as_svg(figure, key)


def _bands(axes: Axes, edges: np.ndarray, rows: Mapping[str, Sequence[float]]) -> None:
    """A band for each row, coloured by its values from 0 to 100."""
    places = np.arange(len(rows) + 1) - 0.5
    drawn = axes.pcolormesh(
        edges, places, np.array(list(rows.values())), cmap="cividis", vmin=0, vmax=100, rasterized=True
    )
    axes.set_yticks(np.arange(len(rows)), [words(name) for name in rows], fontsize=8)
    axes.invert_yaxis()
    axes.figure.colorbar(drawn, ax=axes, aspect=8, pad=0.01)


@STYLED
def latency_plot(title: str, levels: Mapping[str, np.ndarray], key: str) -> str:
    """Share of the requests answered within so many cycles, a line for each level; `levels`: requests by class."""
    figure = Figure(figsize=(5.6, 3.4), layout="constrained")
    axes = figure.subplots()
    starts = np.array([shortest(number) for number in range(NUM_CLASSES)])
    for (level, counts), colour in zip(
        levels.items(), (SKY, BLUE, ORANGE, VERMILLION, GREEN) * 9, strict=False
    ):
        if counts.any():
            last = int(np.flatnonzero(counts)[-1]) + 2
            reached = 100.0 * np.cumsum(counts)[: last - 1] / counts.sum()
            edges = np.maximum(starts[:last], 0.5)
            axes.stairs(reached, edges, baseline=None, color=colour, label=words(level), linewidth=1.4)
    axes.set(title=title, xscale="log", xlabel="cycles from request to answer", ylabel="answered by then [%]")
    axes.set_ylim(0, 102)
    plain_ticks(axes.xaxis)
    axes.legend(frameon=False)
    return as_svg(figure, key)
