"""The statistics of an irregular shadow map that are not counters of a component."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from archsim.machine.counters import Counters
from archsim.raster.eye_view import EyeView
from archsim.run.measure import Measure, measured, ratio
from archsim.run.result import Check, Statistic
from archsim.shadow.workload import IzbWorkload

CLEAR, BUILD, RASTER = "izb_clear", "izb_build", "izb_raster"


class WorkloadView(NamedTuple):
    """What the algorithm counted."""

    workload: IzbWorkload
    num_views: int


class PictureView(NamedTuple):
    """What is seen."""

    seen: EyeView
    shadow: np.ndarray  # bool [height, width]


class CostView(NamedTuple):
    """A phase's counters beside what they were spent on."""

    workload: IzbWorkload
    counters: Counters


WORKLOAD = [
    Measure(
        "samples",
        "samples",
        "Pixels that show geometry and are not at the light itself.",
        lambda view: view.workload.samples,
    ),
    Measure(
        "light_views",
        "views",
        "Perspective views that the light needed to hold all samples.",
        lambda view: view.num_views,
    ),
    Measure(
        "depth_complexity",
        "triangles",
        "Triangles covering a sample in the light view.",
        lambda view: view.workload.depth_complexity,
    ),
    Measure(
        "list_length",
        "samples",
        "Samples in a list, over the non-empty physical cells.",
        lambda view: view.workload.list_length,
    ),
    Measure(
        "non_empty_cells",
        "cells",
        "Physical cells whose list holds a sample.",
        lambda view: view.workload.non_empty_cells,
    ),
    Measure(
        "stencil_width",
        "cells",
        "Columns from the first to the last populated logical cell.",
        lambda view: view.workload.stencil_width,
    ),
    Measure(
        "stencil_height",
        "cells",
        "Rows from the first to the last populated logical cell.",
        lambda view: view.workload.stencil_height,
    ),
    Measure(
        "grid_fragments_pre_stencil",
        "grid fragments",
        "Cells overlapped by triangles.",
        lambda view: view.workload.grid_fragments_pre_stencil,
    ),
    Measure(
        "grid_fragments_post_stencil",
        "grid fragments",
        "Cells overlapped by triangles whose stencil is marked.",
        lambda view: view.workload.grid_fragments_post_stencil,
    ),
    Measure(
        "node_visits",
        "nodes",
        "List nodes tested, over all grid fragments.",
        lambda view: view.workload.node_visits,
    ),
    Measure(
        "framebuffer_fragments_pre_z",
        "framebuffer fragments",
        "Samples inside triangles.",
        lambda view: view.workload.framebuffer_fragments_pre_z,
    ),
    Measure(
        "framebuffer_fragments_post_z",
        "framebuffer fragments",
        "Samples inside triangles that pass the z test.",
        lambda view: view.workload.framebuffer_fragments_post_z,
    ),
]

PICTURE = [
    Measure(
        "eye_depth_complexity",
        "triangles",
        "Triangles that a pixel's ray meets.",
        lambda view: view.seen.covered.mean(),
    ),
    Measure(
        "shadow_percent", "%", "Pixels in shadow over all pixels.", lambda view: 100.0 * view.shadow.mean()
    ),
]

BUILD_COST = [
    Measure(
        "cycles_per_point",
        "cycles",
        "Build cycles over samples.",
        lambda view: ratio(view.counters.cycles, view.workload.samples),
    ),
]

RASTER_COST = [
    Measure(
        "cycles_per_tri_sample",
        "cycles",
        "Raster cycles over framebuffer fragments pre z.",
        lambda view: ratio(view.counters.cycles, view.workload.framebuffer_fragments_pre_z),
    ),
]


def picture_statistics(seen: EyeView, shadow: np.ndarray) -> list[Statistic]:
    """What the picture shows."""
    return measured("workload", PICTURE, PictureView(seen, shadow))


def workload_statistics(workload: IzbWorkload, num_views: int) -> list[Statistic]:
    """What the algorithm asks of the machine."""
    return measured("workload", WORKLOAD, WorkloadView(workload, num_views))


def paper_ratios(workload: IzbWorkload, build: Counters, raster: Counters) -> list[Statistic]:
    """The two costs that [Johnson04] tables 3 and 4 print."""
    return [
        *measured(BUILD, BUILD_COST, CostView(workload, build)),
        *measured(RASTER, RASTER_COST, CostView(workload, raster)),
    ]


def summary(statistics: list[Statistic], checks: list[Check]) -> dict[str, Any]:
    names = [
        "workload.samples",
        "workload.shadow_percent",
        "workload.light_views",
        f"{BUILD}.cycles",
        f"{BUILD}.cycles_per_point",
        f"{BUILD}.useful_percent",
        f"{RASTER}.cycles",
        f"{RASTER}.cycles_per_tri_sample",
        f"{RASTER}.useful_percent",
    ]
    values = {statistic.name: statistic.value for statistic in statistics}
    return {**{name: values[name] for name in names}, "checks_passed": all(check.ok for check in checks)}
