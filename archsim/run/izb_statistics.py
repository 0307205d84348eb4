"""The statistics of an irregular shadow map that are not counters of a component."""

from __future__ import annotations

from typing import Any

import numpy as np

from archsim.machine.counters import Counters
from archsim.raster.eye_view import EyeView
from archsim.run.metrics import ratio
from archsim.run.result import Check, Statistic
from archsim.shadow.workload import IzbWorkload

BUILD, RASTER = "izb_build", "izb_raster"


def picture_statistics(seen: EyeView, shadow: np.ndarray) -> list[Statistic]:
    """What the picture shows."""
    layers, shadowed = float(seen.covered.mean()), 100.0 * float(shadow.mean())
    return [
        Statistic(
            "workload.eye_depth_complexity", layers, "triangles", "Triangles that a pixel's ray meets."
        ),
        Statistic("workload.shadow_percent", shadowed, "%", "Pixels in shadow over all pixels."),
    ]


def workload_statistics(workload: IzbWorkload, num_views: int) -> list[Statistic]:
    pre, post = "grid fragments", "framebuffer fragments"
    rows = [
        (
            "samples",
            workload.samples,
            "samples",
            "Pixels that show geometry and are not at the light itself.",
        ),
        ("light_views", num_views, "views", "Perspective views that the light needed to hold all samples."),
        (
            "depth_complexity",
            workload.depth_complexity,
            "triangles",
            "Triangles covering a sample in the light view.",
        ),
        (
            "list_length",
            workload.list_length,
            "samples",
            "Samples in a list, over the non-empty physical cells.",
        ),
        ("non_empty_cells", workload.non_empty_cells, "cells", "Physical cells whose list holds a sample."),
        ("stencil_width", workload.stencil_width, "cells", "Extent of the populated logical cells."),
        ("stencil_height", workload.stencil_height, "cells", "Extent of the populated logical cells."),
        (
            "grid_fragments_pre_stencil",
            workload.grid_fragments_pre_stencil,
            pre,
            "Cells overlapped by triangles.",
        ),
        ("grid_fragments_post_stencil", workload.grid_fragments_post_stencil, pre, "Those on a marked cell."),
        ("node_visits", workload.node_visits, "nodes", "List nodes tested, over all grid fragments."),
        (
            "framebuffer_fragments_pre_z",
            workload.framebuffer_fragments_pre_z,
            post,
            "Samples inside triangles.",
        ),
        (
            "framebuffer_fragments_post_z",
            workload.framebuffer_fragments_post_z,
            post,
            "Those that pass the z test.",
        ),
    ]
    return [Statistic(f"workload.{name}", value, unit, text) for name, value, unit, text in rows]


def paper_ratios(workload: IzbWorkload, build: Counters, raster: Counters) -> list[Statistic]:
    per_point = ratio(build.cycles, workload.samples)
    per_fragment = ratio(raster.cycles, workload.framebuffer_fragments_pre_z)
    return [
        Statistic(f"{BUILD}.cycles_per_point", per_point, "cycles", "Build cycles over samples."),
        Statistic(
            f"{RASTER}.cycles_per_tri_sample",
            per_fragment,
            "cycles",
            "Raster cycles over framebuffer fragments pre z.",
        ),
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
