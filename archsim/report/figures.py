"""Figures as inline SVG: labelled axes with units, and colours that colour-blind readers can tell apart."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.container import Container
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from archsim.report.formats import words
from archsim.report.statistics import Phase
from archsim.run.result import Histogram

# Okabe and Ito's palette.
GREEN, BLUE, SKY, ORANGE = "#009E73", "#0072B2", "#56B4E9", "#E69F00"
VERMILLION, PURPLE, YELLOW, GREY = "#D55E00", "#CC79A7", "#F0E442", "#BBBBBB"
OUTCOMES = (GREEN, SKY, VERMILLION)  # hits, what is between, the bad case
_SUPPLIERS = (SKY, BLUE, ORANGE, YELLOW)  # of stalls on caches, nearest to the cores first
_NO_BAR = 0.5  # on a logarithmic axis of counts, so that what occurs once has a bar

STYLED = matplotlib.rc_context(
    {
        "svg.fonttype": "none",
        "svg.hashsalt": "archsim",
        "font.family": "DejaVu Sans",
        "font.size": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.titlesize": 11,
        "axes.titlelocation": "left",
        "axes.titleweight": "bold",
    }
)


@STYLED
def speed_of_light(shares: Sequence[tuple[str, float]]) -> str:
    """How near each resource is to its peak: (label, per cent of peak)."""
    figure = Figure(figsize=(11.4, 0.6 + 0.34 * len(shares)), layout="constrained")
    axes = figure.subplots()
    labels, values = [label for label, _ in shares], [value for _, value in shares]
    axes.barh(labels, [100.0] * len(shares), color="#EEEEEE", height=0.66)
    bars = axes.barh(labels, values, color=BLUE, height=0.66)
    axes.bar_label(bars, [f"{value:.1f} %" for value in values], padding=4)
    axes.set(xlim=(0, 108), xlabel="share of the resource's peak [%]")
    axes.invert_yaxis()
    return as_svg(figure, "light")


@STYLED
def stall_stack(phases: Mapping[str, Phase]) -> str:
    """What became of the issue slots of each phase; beside it the empty ones alone, larger."""
    figure = Figure(figsize=(11.4, 1.3 + 0.42 * len(phases)), layout="constrained")
    whole, empty = figure.subplots(1, 2, sharey=True)
    for label, phase in phases.items():
        stalls, colours = phase.stalls(), _reason_colours(phase)
        _stack(whole, label, stalls, colours)
        _stack(empty, label, {reason: v for reason, v in stalls.items() if reason != "useful"}, colours)
    whole.set(xlim=(0, 100), xlabel="share of issue slots [%]", title="All issue slots")
    empty.set(xlabel="share of issue slots [%]", title="Empty slots only")
    empty.set_xlim(0, max(empty.get_xlim()[1], 0.1))
    whole.invert_yaxis()
    _legend(figure, [*whole.containers, *empty.containers])
    return as_svg(figure, "stalls")


@STYLED
def unit_stack(title: str, shares: Mapping[str, Mapping[str, float]], key: str) -> str:
    """What became of the cycles of each unit: `busy`, then each place to wait, in per cent."""
    figure = Figure(figsize=(11.4, 1.3 + 0.34 * len(shares)), layout="constrained")
    axes = figure.subplots()
    taken = {place for parts in shares.values() for place, share in parts.items() if share >= 0.05}
    for label, parts in shares.items():
        shown = {place: share for place, share in parts.items() if place in taken}
        _stack(axes, words(label), shown, _place_colours(parts))
    axes.set(xlim=(0, 100), xlabel="share of cycles [%]", title=title)
    axes.invert_yaxis()
    _legend(figure, axes.containers)
    return as_svg(figure, key)


@STYLED
def cause_bars(
    waiting: Mapping[str, Mapping[str, float]], title: str, key: str, of_all: str = "issue slots"
) -> str:
    """What each of some waited for: a bar for each cause, from the nearest to the DRAM, that took 0.05 % or more."""
    waiting = {label: causes for label, causes in waiting.items() if any(causes.values())}
    taken = {cause: None for causes in waiting.values() for cause, share in causes.items() if share >= 0.05}
    if not taken:
        return ""
    causes = sorted(taken, key=lambda cause: cause.startswith("dram."))
    figure = Figure(figsize=(11.4, 1.4 + 0.12 * len(causes) * (1 + len(waiting))), layout="constrained")
    axes = figure.subplots()
    height = 0.8 / len(waiting)
    colours = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, YELLOW, GREY) * 9
    for number, ((label, shares), colour) in enumerate(zip(waiting.items(), colours, strict=False)):
        places = np.arange(len(causes)) + height * number - 0.4 + height / 2
        values = [shares.get(cause, 0.0) for cause in causes]
        bars = axes.barh(places, values, height, color=colour, label=words(label))
        texts = [f"{value:.1f}" if value >= 0.05 else "" for value in values]
        axes.bar_label(bars, texts, padding=3, fontsize=7)
    axes.set_yticks(np.arange(len(causes)), [words(cause.replace(".", ": ")) for cause in causes])
    axes.set(xlabel=f"share of {of_all} [%]", title=title)
    axes.set_ylim(len(causes) - 0.4, -0.6)
    figure.legend(loc="outside lower center", ncols=8, frameon=False)
    return as_svg(figure, key)


class Roof(NamedTuple):
    """A phase under its machine's roofs."""

    intensity: float  # instructions for each byte that the DRAM moved
    instructions: float  # a cycle
    peak_instructions: float  # a cycle
    peak_bytes: float  # a cycle


@STYLED
def roofline(roofs: Mapping[str, Roof]) -> str:
    """Each phase as a point under the roof of its cores and its DRAM; nothing without phases."""
    if not roofs:
        return ""
    figure = Figure(figsize=(7.4, 4.0), layout="constrained")
    axes = figure.subplots()
    intensities = [roof.intensity for roof in roofs.values()]
    knees = [roof.peak_instructions / roof.peak_bytes for roof in roofs.values()]
    x = np.geomspace(min(*intensities, *knees) / 4, max(*intensities, *knees) * 4, 200)
    for (label, roof), colour in zip(
        roofs.items(), (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY) * 9, strict=False
    ):
        axes.plot(x, np.minimum(roof.peak_instructions, roof.peak_bytes * x), color=colour, linewidth=1.2)
        axes.plot(roof.intensity, roof.instructions, "o", color=colour, markersize=8, label=words(label))
    axes.set(xscale="log", yscale="log")
    axes.set(xlabel="intensity [instructions/DRAM byte]", ylabel="rate [instructions/cycle]")
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.legend(frameon=False, loc="lower right")
    return as_svg(figure, "roofline")


@STYLED
def shares(rows: Mapping[str, Mapping[str, float]], colours: Sequence[str], unit: str, key: str) -> str:
    """Stacked bars of row -> {part: amount}, each row as shares of its total."""
    figure = Figure(figsize=(11.4, 1.1 + 0.36 * len(rows)), layout="constrained")
    axes = figure.subplots()
    for label, parts in rows.items():
        total = sum(parts.values()) or 1.0
        in_percent = {part: 100.0 * amount / total for part, amount in parts.items()}
        _stack(axes, label, in_percent, dict(zip(parts, colours, strict=True)))
    axes.set(xlim=(0, 100), xlabel=f"share of {unit} [%]")
    axes.invert_yaxis()
    _legend(figure, axes.containers)
    return as_svg(figure, key)


@STYLED
def histogram(data: Histogram, key: str) -> str:
    """Counts over values; a logarithmic count axis, and the mean marked."""
    counts = np.asarray(data.counts)
    values = np.arange(len(counts))
    figure = Figure(figsize=(5.6, 3.0), layout="constrained")
    axes = figure.subplots()
    edges = np.arange(len(counts) + 1) - 0.5
    axes.stairs(
        np.maximum(counts, _NO_BAR), edges, baseline=_NO_BAR, fill=True, color=BLUE
    )  # one shape, not thousands
    mean = float((values * counts).sum() / max(int(counts.sum()), 1))
    axes.axvline(mean, color=VERMILLION, linestyle="--", label=f"mean {mean:.3g}")
    axes.set(
        title=data.title,
        xlabel=f"[{data.unit}]",
        ylabel=f"number of {data.counted}",
        xlim=(-0.5, max(len(counts) - 0.5, 1)),
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if counts.any():
        axes.set_yscale("log")
        axes.set_ylim(bottom=_NO_BAR)
        plain_ticks(axes.yaxis)
    axes.legend(frameon=False)
    return as_svg(figure, key)


@STYLED
def heat_map(title: str, image: np.ndarray, key: str) -> str:
    """An image with its colour bar; grey where there is nothing to show. Few very large values don't flatten it.

    `title` may end in a [unit], which goes to the colour bar.
    """
    what, _, unit = title.removesuffix("]").partition(" [")
    figure = Figure(figsize=(5.6, 4.3), layout="constrained")
    axes = figure.subplots()
    colours = matplotlib.colormaps["cividis"].with_extremes(bad="#DDDDDD")
    finite = image[np.isfinite(image)]
    top = float(np.percentile(finite, 99.5)) if finite.size else 1.0
    clipped = bool(finite.size) and float(finite.max()) > top
    low = float(finite.min()) if finite.size else 0.0
    rows, columns = image.shape
    drawn = axes.imshow(
        np.ma.masked_invalid(image),
        cmap=colours,
        vmin=low,
        vmax=top if top > low else low + 1,
        aspect="equal" if rows <= 2 * columns <= 4 * rows else "auto",  # slivers are drawn wider
    )
    whole = MaxNLocator(integer=True) if (finite == np.round(finite)).all() else None
    extend = "max" if clipped else "neither"
    figure.colorbar(drawn, ax=axes, extend=extend, shrink=0.8, ticks=whole, label=f"[{unit}]" if unit else "")
    figure.suptitle(what, x=0.01, ha="left", fontsize=11, weight="bold")
    axes.set(xlabel="column", ylabel="row")
    return as_svg(figure, key)


def plain_ticks(axis: Axis) -> None:
    """Ticks of a logarithmic axis as plain numbers: 1, 2, 5, 10 ..., or only powers of ten over many decades."""
    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 1000 * low else (1.0,)))
    axis.set_major_formatter(StrMethodFormatter("{x:,.6g}"))
    axis.set_minor_formatter(NullFormatter())


def _place_colours(places: Iterable[str]) -> dict[str, str]:
    """Of what a unit does with its cycles; caches are what is not known by name."""
    known = {"busy": GREEN, "no_work": GREY, "output": YELLOW, "pool": PURPLE, "latency": "#666666"}
    known |= {"delay_stream": ORANGE, "dram": VERMILLION}
    caches = (place for place in places if place not in known)
    return known | dict(zip(caches, (SKY, BLUE) * 9, strict=False))


def _reason_colours(phase: Phase) -> dict[str, str]:
    caches = dict(zip(phase.caches, _SUPPLIERS, strict=False))
    return {"useful": GREEN, "no_work": GREY, "lock": PURPLE, **caches, "dram": VERMILLION}


def _stack(axes: Axes, label: str, parts: Mapping[str, float], colours: Mapping[str, str]) -> None:
    """One horizontal bar of parts, those that are wide enough labelled inside."""
    left = 0.0
    for part, value in parts.items():
        bar = axes.barh([label], [value], left=left, height=0.66, color=colours[part], label=part)
        if value > 12:
            axes.bar_label(bar, [f"{value:.1f}"], label_type="center", color=_ink(colours[part]), fontsize=9)
        left += value


def _legend(figure: Figure, bars: Iterable[Container]) -> None:
    """One entry for each part of the stacked bars, below the axes."""
    handles: dict[str, Any] = {words(str(bar.get_label())): bar for bar in bars}
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=8, frameon=False)


def _ink(colour: str) -> str:
    """What is readable on a colour."""
    return "white" if colour in (GREEN, BLUE, VERMILLION) else "black"


def as_svg(figure: Figure, key: str) -> str:
    """The figure as an SVG element; `key` keeps its ids apart from those of the other figures of a page."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None})
    text = stream.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    return re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{key}-", text)


@STYLED
def quality_plot(title: str, points: Sequence[Any]) -> str:
    """Image error over map samples, a line for each method; `points` have method, num_samples and l2."""
    figure = Figure(figsize=(8.0, 4.6), layout="constrained")
    axes = figure.subplots()
    methods = dict.fromkeys(point.method for point in points)
    for method, colour in zip(methods, (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, GREY), strict=False):
        own = [point for point in points if point.method == method]
        samples, errors = [point.num_samples for point in own], [point.l2 for point in own]
        axes.plot(samples, errors, marker="o", color=colour, label=method)
    axes.set(title=title, xlabel="shadow-map samples", ylabel="L2 error of the picture [brightness, RMS]")
    axes.set_xscale("log")
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False)
    return as_svg(figure, "quality")
