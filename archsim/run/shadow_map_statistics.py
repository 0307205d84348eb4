"""The statistics of shadow maps that are not counters of a component."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from archsim.lograster.grid import lost_rows, make_grid
from archsim.run.measure import Measure, percent, ratio
from archsim.run.tile_pipeline import PlayedMap


class Together(NamedTuple):
    """All maps of a frame, drawn one after the other."""

    played: Sequence[PlayedMap]
    hertz: float  # of the pipeline's clock

    def total(self, value: Callable[[PlayedMap], Any]) -> Any:
        """The sum over the maps."""
        return sum(value(each) for each in self.played)

    @property
    def cycles(self) -> int:
        return int(self.total(lambda each: each.counters.cycles))

    @property
    def moved(self) -> int:
        """Bytes of depth read and written."""
        return int(self.total(lambda each: each.read + each.written))


class Frame(NamedTuple):
    """The picture that the maps shadow."""

    seen: np.ndarray  # bool [height, width]
    shadow: np.ndarray  # bool [height, width]
    error: np.ndarray  # float64 [n] m of the pixels seen

    def below(self, share: float) -> float:
        """m that a share of the pixels stay below, in per cent."""
        return float(np.percentile(self.error, share)) if len(self.error) else 0.0


class Comparison(NamedTuple):
    """The same picture as the maps shadow it and as it should be."""

    seen: np.ndarray  # bool [height, width]
    shadow: np.ndarray  # bool [height, width]
    expected: np.ndarray  # bool [height, width]

    def wrong(self, dark: bool) -> float:
        """Share of the pixels seen that are dark, or light, and should not be."""
        wrong = self.seen & (self.shadow != self.expected) & (self.shadow == dark)
        return percent(wrong.sum(), self.seen.sum())


def _texels(each: PlayedMap) -> int:
    return int(each.map.depth.size)


TOGETHER = [
    Measure("count", "maps", "Shadow maps.", lambda view: len(view.played)),
    Measure("texels", "texels", "Of all maps together.", lambda view: view.total(_texels)),
    Measure(
        "storage_bytes",
        "bytes",
        "Three for each texel: compression saves no storage.",
        lambda view: 3 * view.total(_texels),
    ),
    Measure("cycles", "cycles", "Of all maps, one after the other.", lambda view: view.cycles),
    Measure(
        "frames_per_second",
        "frames/s",
        "Clock frequency of the pipeline over cycles: the rate if shadow maps were all there is.",
        lambda view: ratio(view.hertz, view.cycles),
    ),
    Measure(
        "triangles",
        "triangles",
        "Set up: all of the mesh for each map.",
        lambda view: view.total(lambda each: each.tasks("setup") - 1),
    ),
    Measure(
        "tiles",
        "tiles",
        "That fine rasterization took, one for each triangle that reaches it.",
        lambda view: view.total(lambda each: each.tasks("fine") - 1),
    ),
    Measure(
        "tiles_per_cycle",
        "tiles/cycle",
        "Tiles over cycles; the paper's goal for the rasterizer is 1.",
        lambda view: ratio(view.total(lambda each: each.tasks("fine") - 1), view.cycles),
    ),
    Measure(
        "read_bytes", "bytes", "Of depth, into the z cache.", lambda view: view.total(lambda each: each.read)
    ),
    Measure(
        "written_bytes",
        "bytes",
        "Of depth, from the z cache; partly drawn tiles each time they leave.",
        lambda view: view.total(lambda each: each.written),
    ),
    Measure(
        "plain_read_bytes",
        "bytes",
        "What would be read if nothing were compressed.",
        lambda view: view.total(lambda each: each.map.plain[0]),
    ),
    Measure(
        "plain_written_bytes",
        "bytes",
        "What would be written if nothing were compressed.",
        lambda view: view.total(lambda each: each.map.plain[1]),
    ),
    Measure(
        "plain_bytes",
        "bytes",
        "What would be read and written if nothing were compressed.",
        lambda view: view.total(lambda each: each.map.plain.sum()),
    ),
    Measure(
        "compression",
        "ratio",
        "Bytes read and written without compression over those with it.",
        lambda view: ratio(view.total(lambda each: each.map.plain.sum()), view.moved),
    ),
    Measure(
        "finished_compression",
        "ratio",
        "The same over the finished maps, of the tiles that something touched.",
        lambda view: ratio(
            view.total(lambda each: each.map.plain_held), view.total(lambda each: int(each.map.held.sum()))
        ),
    ),
    Measure(
        "table_bytes",
        "bytes",
        "Of the table of G(y') read.",
        lambda view: view.total(lambda each: each.table_read),
    ),
]

EACH = [
    Measure("columns", "texels", "Columns of the map.", lambda each: each.map.depth.shape[1]),
    Measure("rows", "texels", "Rows of the map.", lambda each: each.map.depth.shape[0]),
    Measure(
        "depth_ratio",
        "ratio",
        "The f/n of its logarithmic rows; 1 if they are evenly spaced.",
        lambda each: each.map.target.grid.ratio,
    ),
    Measure(
        "lost_rows",
        "rows",
        "Rows that fall on their neighbours: more than none beyond (f/n)max.",
        lambda each: lost_rows(each.map.target.grid),
    ),
    Measure(
        "fragments", "samples", "Samples inside triangles.", lambda each: each.map.drawn.counts.fragments
    ),
    Measure(
        "passed",
        "samples",
        "Of those, nearer than what was there.",
        lambda each: each.map.drawn.counts.passed,
    ),
    Measure(
        "switches",
        "triangles",
        "Within which the larger slope changes.",
        lambda each: each.map.drawn.counts.switches,
    ),
]

EVALUATOR = [
    Measure("exponentials", "units", "Units that evaluate exponentials.", lambda view: view[0].exponentials),
    Measure(
        "multipliers",
        "units",
        "For three edges and depth in a tile's first column, and G where rows follow.",
        lambda view: view[0].multipliers,
    ),
    Measure("adders", "units", "That extend the first column to the others.", lambda view: view[0].adders),
    Measure("table_bytes", "bytes", "Of a table for the largest map.", lambda view: view[0].table_bytes),
    Measure("table_reads", "rows", "Read from the table for each tile.", lambda view: view[0].table_reads),
    Measure("latency", "cycles", "From y' to coverage.", lambda view: view[0].latency_cycles),
    Measure("interval", "cycles", "From one tile to the next.", lambda view: view[0].interval_cycles),
    Measure(
        "sustains_a_tile_a_cycle",
        "1 or 0",
        "Whether the interval is one cycle.",
        lambda view: int(view[0].interval_cycles == 1),
    ),
    Measure(
        "row_error",
        "2^-24 maps",
        "How far the design moves a row at most from where full evaluation puts it.",
        lambda view: max(_row_error(each) for each in view[1]),
    ),
]

IMAGE = [
    Measure("pixels", "pixels", "That show something within the view.", lambda frame: frame.seen.sum()),
    Measure(
        "shadow_percent",
        "%",
        "Of those, in shadow.",
        lambda frame: percent(frame.shadow.sum(), frame.seen.sum()),
    ),
    Measure(
        "m_mean",
        "pixels",
        "Mean of m, the longer side of a texel in the image.",
        lambda frame: frame.error.mean() if len(frame.error) else 0.0,
    ),
    Measure("m_95", "pixels", "The m that 95 % of the pixels stay below.", lambda frame: frame.below(95)),
    Measure("m_most", "pixels", "The largest m.", lambda frame: frame.below(100)),
]

COMPARED = [
    Measure(
        "too_dark_percent",
        "%",
        "Pixels in shadow that traced shadows leave lit.",
        lambda both: both.wrong(True),
    ),
    Measure(
        "too_light_percent",
        "%",
        "Pixels lit that traced shadows cover.",
        lambda both: both.wrong(False),
    ),
    Measure("wrong_percent", "%", "Both together.", lambda both: both.wrong(True) + both.wrong(False)),
]


def _row_error(each: PlayedMap) -> int:
    """Of one map."""
    grid = each.map.target.grid
    return int(np.abs(make_grid(len(grid.x), len(grid.y), grid.ratio).y - grid.y).max())
