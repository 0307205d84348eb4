"""The statistics of shadow volumes that are not counters of a component: the rows of [Aila04] table 1."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import mean
from typing import Any

import numpy as np

from archsim.run.measure import Measure
from archsim.shadow_volumes.comparison import Traffic
from archsim.shadow_volumes.volumes import num_drawn

TRAFFIC = [
    Measure(
        "stencil_shadow",
        "bytes",
        "Stencil values read and written in the shadow pass.",
        lambda t: t.stencil_shadow,
    ),
    Measure(
        "depth_shadow",
        "bytes",
        "Compressed tiles of the z-buffer read in the shadow pass.",
        lambda t: t.depth_shadow,
    ),
    Measure(
        "stencil_lighting", "bytes", "Stencil values read in the lighting pass.", lambda t: t.stencil_lighting
    ),
    Measure(
        "psv", "bytes", "Lines of the PSV buffers fetched and written back, without time.", lambda t: t.psv
    ),
    Measure(
        "delay_stream", "bytes", "Written to the delay stream and read from it.", lambda t: t.delay_stream
    ),
    Measure("total", "bytes", "All of these bytes together.", lambda t: t.total),
    Measure("stencil_pixels", "pixels", "Stencil operations on pixels.", lambda t: t.stencil_pixels),
    Measure(
        "sample_operations",
        "operations",
        "Stencil operations of Stage 1 on samples of tiles.",
        lambda t: t.sample_operations,
    ),
    Measure("processed", "pixels", "Stencil operations on pixels and on samples.", lambda t: t.processed),
]

WORKLOAD = [
    Measure(
        "triangles",
        "triangles",
        "Of all shadow volumes, as they are drawn.",
        lambda view: num_drawn(view.seen.volumes),
    ),
    Measure("volumes", "volumes", "Shadow volumes.", lambda view: len(view.seen.volumes.z_pass)),
    Measure(
        "z_pass_volumes",
        "volumes",
        "Those counted before what is visible.",
        lambda view: view.seen.volumes.z_pass.sum(),
    ),
    Measure("shown_pixels", "pixels", "Pixels that show something.", lambda view: view.shown.sum()),
]


def average(traffic: Sequence[Traffic]) -> Any:
    """The mean of every field."""
    return Traffic(*(mean(values) for values in zip(*traffic, strict=True)))


def shadow_percent(shadow: np.ndarray, shown: np.ndarray) -> float:
    """Share of the pixels that show something that is in shadow."""
    return 100.0 * float(shadow.sum()) / max(int(shown.sum()), 1)
