"""The report of one run: a self-contained page, what limits the machine first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from archsim.config.explain import Origin
from archsim.report import figures, time_figures
from archsim.report.advice import advice, pipeline_advice
from archsim.report.figures import Roof
from archsim.report.formats import words
from archsim.report.page import render, shadow_caption, shadow_uri
from archsim.report.statistics import (
    CACHE_COLUMNS,
    DRAM_COLUMNS,
    Phase,
    headlines,
    phases,
    pipeline_phases,
    unit_cycles,
    unit_waits,
)
from archsim.run.result import Result


def run_report(
    result: Result,
    config_yaml: str,
    manifest: Mapping[str, Any],
    origins: Sequence[Origin],
) -> str:
    """The page as HTML text. It needs nothing but itself: no network, no other file."""
    return render(
        "run.html.j2",
        title=result.name,
        subtitle=f"A run of archsim {manifest['archsim']}, {manifest['wall_seconds']:g} s of wall time",
        headlines=headlines(result),
        **_limits(result),
        **_memory([*phases(result), *pipeline_phases(result)]),
        **_pictures(result),
        checks=result.checks,
        failed=[check for check in result.checks if not check.ok],
        statistics=result.statistics,
        config_yaml=config_yaml,
        origins=origins,
        manifest=manifest,
    )


def _limits(result: Result) -> dict[str, Any]:
    """How near each resource came to its peak, and where issue slots and cycles of units went."""
    ran, flowed, waits = phases(result), pipeline_phases(result), unit_waits(result)
    causes = {phase.name: phase.causes() for phase in ran}
    return {
        "timed": bool(ran),
        "moved": bool(ran or flowed),
        "light": figures.speed_of_light(speed_of_light([*ran, *flowed])),
        "advice": [
            *((phase.name, advice(phase)) for phase in ran),
            *((phase.name, pipeline_advice(phase, waits[phase.name])) for phase in flowed),
        ],
        "roofline": figures.roofline({phase.name: roof for phase in ran if (roof := roof_of(phase))}),
        "stalls": figures.stall_stack({phase.name: phase for phase in ran}),
        "causes": figures.cause_bars(causes, "What the empty slots waited for", "causes"),
        "units": [
            figure
            for k, (phase, cycles) in enumerate(unit_cycles(result).items())
            for figure in unit_figures(phase, cycles, waits[phase], f"units{k}")
        ],
    }


def _memory(played: Sequence[Phase]) -> dict[str, Any]:
    """What became of the requests to caches and DRAM."""
    return {
        "outcomes": figures.shares(cache_outcomes(played), figures.OUTCOMES, "lookups", "caches"),
        "cache_columns": CACHE_COLUMNS,
        "cache_rows": [
            (f"{phase.name} {cache}", _below(phase, cache)) for phase in played for cache in phase.caches
        ],
        "rows": figures.shares(row_outcomes(played), figures.OUTCOMES, "requests", "rows"),
        "dram_columns": DRAM_COLUMNS,
        "dram_rows": [(phase.name, _below(phase, "dram")) for phase in played],
    }


def _pictures(result: Result) -> dict[str, Any]:
    """The shadow mask, maps, histograms, and what went on over time."""
    return {
        "shadow": shadow_uri(result.shadow),
        "shadow_caption": shadow_caption(result.shadow),
        "maps": [
            figures.heat_map(title, image, f"map{k}") for k, (title, image) in enumerate(result.maps.items())
        ],
        "latencies": latency_figures(result),
        "series": [
            time_figures.series_plot(words(phase), series, f"series{k}")
            for k, (phase, series) in enumerate(result.series.items())
        ],
        "histograms": [figures.histogram(data, f"histogram{k}") for k, data in enumerate(result.histograms)],
    }


def unit_figures(
    phase: str, cycles: Mapping[str, Mapping[str, float]], waits: Mapping[str, Mapping[str, float]], key: str
) -> list[str]:
    """The cycles of a phase's units by place, and their waits in the memory by cause."""
    in_memory = {
        unit: {cause: share for cause, share in causes.items() if "." in cause}
        for unit, causes in waits.items()
    }
    title = f"{words(phase)}: what the units waited for in caches and DRAM"
    return [
        figures.unit_stack(words(phase), cycles, key),
        figures.cause_bars(in_memory, title, f"{key}causes", "cycles"),
    ]


def latency_figures(result: Result) -> list[str]:
    """How long requests took at every level, a figure for each phase."""
    by_phase: dict[str, dict[str, np.ndarray]] = {}
    for name, counts in result.latencies.items():
        phase, _, level = name.rpartition(".")
        if counts.any():
            by_phase.setdefault(phase, {})[level] = counts
    return [
        time_figures.latency_plot(words(phase), levels, f"latency{k}")
        for k, (phase, levels) in enumerate(by_phase.items())
    ]


def speed_of_light(ran: Sequence[Phase]) -> list[tuple[str, float]]:
    """(resource, per cent of its peak) of every phase."""
    shares = []
    for phase in ran:
        if not phase.units:
            shares.append((f"{phase.name}: issue", float(phase.values["useful_percent"])))
        for unit in phase.units:
            shares.append((f"{phase.name}: {unit}", float(phase.values[f"{unit}.busy_percent"])))
        for cache in phase.caches:
            shares.append((f"{phase.name}: {cache} ports", float(phase.values[f"{cache}.port_percent"])))
        shares.append((f"{phase.name}: DRAM data buses", float(phase.values["dram.bus_percent"])))
    return shares


def roof_of(phase: Phase) -> Roof | None:
    """Where the phase stands under its machine's roofs; None if it moved nothing."""
    values = {name: float(value) for name, value in phase.values.items()}
    if not (values.get("dram.bytes") and values["dram.bus_percent"] and values["useful_percent"]):
        return None
    a_cycle = values["instructions"] / values["cycles"]
    return Roof(
        values["instructions"] / values["dram.bytes"],
        a_cycle,
        100.0 * a_cycle / values["useful_percent"],
        100.0 * values["dram.bandwidth_bytes_per_cycle"] / values["dram.bus_percent"],
    )


def cache_outcomes(ran: Sequence[Phase]) -> dict[str, dict[str, float]]:
    """Hits, merges and misses of every cache."""
    names = ("hits", "merges", "misses")
    return {
        f"{phase.name}: {cache}": {name: float(phase.values[f"{cache}.{name}"]) for name in names}
        for phase in ran
        for cache in phase.caches
    }


def row_outcomes(ran: Sequence[Phase]) -> dict[str, dict[str, float]]:
    """Row hits, misses and conflicts of every phase."""
    names = ("row hits", "row misses", "row conflicts")
    return {
        phase.name: {name: float(phase.values[f"dram.{name.replace(' ', '_')}"]) for name in names}
        for phase in ran
    }


def _below(phase: Phase, component: str) -> dict[str, int | float]:
    """Statistics of one component, by their last names."""
    prefix = f"{component}."
    return {key.removeprefix(prefix): value for key, value in phase.values.items() if key.startswith(prefix)}
