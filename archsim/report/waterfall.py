"""What every thread did in every cycle: a line for each thread, a character or a coloured cell for each cycle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from archsim.machine.pipeline.timeline import DOES
from archsim.machine.timeline import COMPUTE, Place, Timeline, Window
from archsim.report.figures import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, STYLED, VERMILLION, YELLOW, as_svg

_LETTERS = {COMPUTE: "c", "LOAD": "L", "STORE": "S", "LOCK": "K", "UNLOCK": "U", "EMIT": "E"}
LEGEND = "c compute, L load, S store, K lock, U unlock, E emit; waiting for 0-9 a cache, D the DRAM, k a lock, . a task"

# What the figure of threads tells apart: label, colour, letters.
_OF_THREADS = (
    ("ready or idle", "#FFFFFF", " "),
    ("compute", GREEN, "c"),
    ("load, store", BLUE, "LS"),
    ("lock, unlock", PURPLE, "KU"),
    ("emit", YELLOW, "E"),
    ("waits for a cache", SKY, "0123456789"),
    ("waits for the DRAM", VERMILLION, "D"),
    ("waits for a lock", ORANGE, "k"),
    ("waits for a task", GREY, "."),
)

# And that of units.
_OF_UNITS = (
    ("not recorded", "#FFFFFF", " "),
    ("busy", GREEN, "B"),
    ("memory", VERMILLION, "M"),
    ("output full", PURPLE, "O"),
    ("delay stream full", SKY, "d"),
    ("latency", YELLOW, "l"),
    ("pool", ORANGE, "p"),
    ("no work", GREY, "."),
)
_LETTER_OF_SLOT = dict(zip(DOES.values(), "B.MOdlp", strict=True))
UNIT_LEGEND = "B busy, M memory, O output full, d delay stream full, l latency, p pool, . no work"


def waterfall(timeline: Timeline, window: Window, units: Sequence[str] = ()) -> str:
    """The cycles as text; `units` are those of a pipeline."""
    lines = _lines(timeline, window)
    names = _names(timeline, units)
    width = max(len(name) for name in names)
    head = f"cycles {window.first} to {window.last - 1}"
    rows = [f"{name:<{width}} |{line}|" for name, line in zip(names, lines, strict=True)]
    return "\n".join([head, *rows, UNIT_LEGEND if units else LEGEND]) + "\n"


@STYLED
def waterfall_figure(timeline: Timeline, window: Window, units: Sequence[str] = ()) -> str:
    """The cycles as an SVG element."""
    lines, table = _lines(timeline, window), _OF_UNITS if units else _OF_THREADS
    number = {letter: index for index, (_, _, letters) in enumerate(table) for letter in letters}
    cells = np.array([[number[letter] for letter in line] for line in lines])
    figure = Figure(figsize=(11.4, 1.4 + 0.24 * len(lines)), layout="constrained")
    axes = figure.subplots()
    colours = ListedColormap([colour for _, colour, _ in table])
    extent = (window.first - 0.5, window.last - 0.5, len(lines) - 0.5, -0.5)
    axes.imshow(
        cells, cmap=colours, vmin=0, vmax=len(table) - 1, aspect="auto", interpolation="none", extent=extent
    )
    axes.set_yticks(range(len(lines)), _names(timeline, units))
    axes.set_xlabel("cycle")
    patches = [Patch(facecolor=colour, edgecolor="#888888", label=label) for label, colour, _ in table]
    figure.legend(handles=patches, loc="outside lower center", ncols=5, frameon=False)
    return as_svg(figure, "waterfall")


def _names(timeline: Timeline, units: Sequence[str]) -> list[str]:
    return [units[core] if units else f"core {core} thread {thread:>2}" for core, thread in timeline.waits]


def _lines(timeline: Timeline, window: Window) -> list[str]:
    """Of each thread or unit a letter for each cycle, a blank where a thread is ready and another one issues."""
    period, num_cycles = timeline.period_ticks, window.last - window.first
    lines = {own: [" "] * num_cycles for own in timeline.waits}

    def put(own: Place, first: int, last: int, letter: str) -> None:
        for cycle in range(max(first, window.first), min(last, window.last)):
            lines[own][cycle - window.first] = letter

    for own, waits in timeline.waits.items():
        for wait in waits:
            put(own, wait.start // period, wait.end // period, _waiting(wait.name))
    for slot in timeline.slots:
        put((slot.core, slot.thread), slot.tick // period, slot.tick // period + 1, _LETTERS[slot.op])
    return ["".join(line) for line in lines.values()]


def _waiting(name: str) -> str:
    if name in _LETTER_OF_SLOT:
        return _LETTER_OF_SLOT[name]
    return {"lock": "k", "dram": "D"}.get(name, name[-1])
