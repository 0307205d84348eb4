"""Every statistic that a run can have: where its table stands, and the reference made of the tables."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from archsim.run import (
    izb_statistics,
    metrics,
    pipeline_metrics,
    replay_statistics,
    series,
    shadow_map_statistics,
    shadow_volume_kernels,
    shadow_volume_statistics,
    stall_metrics,
    walkthrough,
)
from archsim.run.measure import Measure, Table


class Section(NamedTuple):
    """One table and the names that its statistics get."""

    title: str
    prefix: str  # names in braces stand for a phase, a cache, or a level of the memory system
    table: Table


SECTIONS = [
    Section("Cores, in every phase", "{phase}", metrics.CORES),
    Section("What the cores waited for, for every cache and the DRAM", "{phase}", stall_metrics.LEVELS),
    Section("What the cores waited for at every cache", "{phase}", stall_metrics.AT_CACHE),
    Section("What the cores waited for at the DRAM", "{phase}", stall_metrics.AT_DRAM),
    Section("Every interval of a phase, in `result.json` only", "series.{phase}", series.INTERVALS),
    Section("Every interval of a phase: cores", "series.{phase}", series.OF_CORES),
    Section("Every interval of a phase: every cache", "series.{phase}.{cache}", series.OF_CACHES),
    Section("Every interval of a pipeline: every unit", "series.{pipeline}.{unit}", series.OF_UNITS),
    Section(
        "Every interval of a pipeline: every fifo and delay stream",
        "series.{pipeline}.{channel}",
        series.OF_CHANNELS,
    ),
    Section("Locks, in every phase", "{phase}.locks", metrics.LOCKS),
    Section("Every cache, in every phase; caches of one name are summed", "{phase}.{cache}", metrics.CACHES),
    Section("DRAM, in every phase, summed over the channels", "{phase}.dram", metrics.DRAM),
    Section("Pipelines, besides the statistics of caches and DRAM", "{pipeline}", pipeline_metrics.RUN),
    Section("Every unit of a pipeline", "{pipeline}.{unit}", pipeline_metrics.UNITS),
    Section(
        "What a unit waited for, for every cache below it and the DRAM",
        "{pipeline}.{unit}",
        stall_metrics.LEVELS,
    ),
    Section("What a unit waited for at every cache below it", "{pipeline}.{unit}", stall_metrics.AT_CACHE),
    Section("What a unit waited for at the DRAM", "{pipeline}.{unit}", stall_metrics.AT_DRAM),
    Section("Every fifo and delay stream of a pipeline", "{pipeline}.{channel}", pipeline_metrics.CHANNELS),
    Section("Every delay stream of a pipeline", "{pipeline}.{delay_stream}", pipeline_metrics.STREAMS),
    Section("Every pool of a pipeline", "{pipeline}.{pool}", pipeline_metrics.POOLS),
    Section("Irregular shadow mapping: the workload", "workload", izb_statistics.WORKLOAD),
    Section("Irregular shadow mapping: the picture", "workload", izb_statistics.PICTURE),
    Section("Irregular shadow mapping: the build phase", "izb_build", izb_statistics.BUILD_COST),
    Section("Irregular shadow mapping: the raster phase", "izb_raster", izb_statistics.RASTER_COST),
    Section("Shadow volumes: the workload", "workload", shadow_volume_statistics.WORKLOAD),
    Section("Shadow volumes: what the algorithm moves", "traffic", shadow_volume_statistics.TRAFFIC),
    Section("Shadow volumes on cores", "programmable", shadow_volume_kernels.PROGRAMMABLE),
    Section("Shadow maps: all together", "maps", shadow_map_statistics.TOGETHER),
    Section("Shadow maps: each, besides what is said of pipelines", "{map}", shadow_map_statistics.EACH),
    Section("Shadow maps: the evaluator of G(y')", "evaluator", shadow_map_statistics.EVALUATOR),
    Section("Shadow maps: the picture", "image", shadow_map_statistics.IMAGE),
    Section("Shadow maps: the picture beside a traced one", "image", shadow_map_statistics.COMPARED),
    Section("Walkthroughs with shadow volumes", "walkthrough", walkthrough.COUNTS),
    Section("Walkthroughs: each variant, averaged", "{variant}", shadow_volume_statistics.TRAFFIC),
    Section("Replayed address traces: the trace", "trace", replay_statistics.TRACE),
    Section("Replayed without time: every cache", "{cache}", replay_statistics.LEVEL),
    Section("Replayed without time: what reaches the DRAM", "dram", replay_statistics.MEMORY),
    Section(
        "Replayed with time, besides those of caches and DRAM in a phase, whose names begin with no phase then",
        "replay",
        replay_statistics.REPLAY,
    ),
    Section("Replayed with time: the DRAM's speed", "dram", replay_statistics.SPEED),
    Section("Replayed on a DRAM alone, besides the same", "dram", replay_statistics.READ_TIMES),
]

_HEAD = """\
# Statistics

Every number in `result.json`, with its unit and the one sentence that defines it. `{phase}` is a phase of the
workload, such as `izb_build`, and `{pipeline}` one that a pipeline plays; `{cache}` is a cache of the machine by name,
such as `l2`; `{level}` is a cache, or `dram`; `{variant}`
is `brute_force`, `depth_bounds` or `hierarchical`; `{map}` is a shadow map by name, such as `map_left`. This page is
printed by `archsim statistics`.
"""


def reference() -> str:
    """The statistics reference as a page of Markdown."""
    return "\n".join([_HEAD, *(_section(section) for section in SECTIONS)])


def entries() -> Iterator[tuple[str, Measure]]:
    """(full name with braces, line of its table) of every statistic."""
    for section in SECTIONS:
        for measure in section.table:
            yield f"{section.prefix}.{measure.name}", measure


def _section(section: Section) -> str:
    rows = [
        f"| `{section.prefix}.{measure.name}` | {measure.unit} | {measure.definition} |"
        for measure in section.table
    ]
    head = ["| statistic | unit | definition |", "|---|---|---|"]
    return "\n".join([f"## {section.title}", "", *head, *rows, ""])
