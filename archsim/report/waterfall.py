"""What every thread did in every cycle: a line for each thread, a character or a coloured cell for each cycle."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from archsim.machine.timeline import COMPUTE, Timeline
from archsim.report.figures import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, STYLED, VERMILLION, YELLOW, as_svg

_LETTERS = {COMPUTE: "c", "LOAD": "L", "STORE": "S", "LOCK": "K", "UNLOCK": "U", "EMIT": "E"}
LEGEND = "c compute, L load, S store, K lock, U unlock, E emit; waiting for 0-9 a cache, D the DRAM, k a lock, . a task"

# What the figure tells apart: label, colour, letters.
_CELLS = (
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


def waterfall(timeline: Timeline, first_cycle: int, num_cycles: int) -> str:
    """The cycles as text."""
    lines = _lines(timeline, first_cycle, num_cycles)
    head = f"cycles {first_cycle} to {first_cycle + num_cycles - 1}"
    rows = [f"core {core} thread {thread:>2} |{line}|" for (core, thread), line in lines.items()]
    return "\n".join([head, *rows, LEGEND]) + "\n"


@STYLED
def waterfall_figure(timeline: Timeline, first_cycle: int, num_cycles: int) -> str:
    """The cycles as an SVG element."""
    lines = _lines(timeline, first_cycle, num_cycles)
    number = {letter: index for index, (_, _, letters) in enumerate(_CELLS) for letter in letters}
    cells = np.array([[number[letter] for letter in line] for line in lines.values()])
    figure = Figure(figsize=(11.4, 1.4 + 0.24 * len(lines)), layout="constrained")
    axes = figure.subplots()
    colours = ListedColormap([colour for _, colour, _ in _CELLS])
    extent = (first_cycle - 0.5, first_cycle + num_cycles - 0.5, len(lines) - 0.5, -0.5)
    axes.imshow(
        cells, cmap=colours, vmin=0, vmax=len(_CELLS) - 1, aspect="auto", interpolation="none", extent=extent
    )
    axes.set_yticks(range(len(lines)), [f"core {core} thread {thread}" for core, thread in lines])
    axes.set_xlabel("core cycle")
    patches = [Patch(facecolor=colour, edgecolor="#888888", label=label) for label, colour, _ in _CELLS]
    figure.legend(handles=patches, loc="outside lower center", ncols=5, frameon=False)
    return as_svg(figure, "waterfall")


def _lines(timeline: Timeline, first_cycle: int, num_cycles: int) -> dict[tuple[int, int], str]:
    """(core, thread) -> a letter for each cycle, a blank where the thread is ready and another one issues."""
    period = timeline.spec.core.period_ticks
    lines = {own: [" "] * num_cycles for own in timeline.waits}

    def put(own: tuple[int, int], cycle: int, letter: str) -> None:
        if 0 <= cycle - first_cycle < num_cycles:
            lines[own][cycle - first_cycle] = letter

    for own, waits in timeline.waits.items():
        for wait in waits:
            for cycle in range(wait.start // period, wait.end // period):
                put(own, cycle, _waiting(wait.name))
    for slot in timeline.slots:
        put((slot.core, slot.thread), slot.tick // period, _LETTERS[slot.op])
    return {own: "".join(line) for own, line in lines.items()}


def _waiting(name: str) -> str:
    return {"no work": ".", "lock": "k", "dram": "D"}.get(name, name[-1])
