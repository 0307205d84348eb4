"""The statistics of a run as a page wants them: found by their names, arranged by phase and component."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from archsim.run.result import Result, Statistic

CACHE_COLUMNS = (
    ("accesses", "accesses"),
    ("hit_percent", "hits %"),
    ("merges", "merges"),
    ("misses", "misses"),
    ("fetches", "fetches"),
    ("writebacks", "write-backs"),
    ("average_miss_cycles", "cycles a miss"),
    ("port_percent", "ports busy %"),
)
DRAM_COLUMNS = (
    ("reads", "reads"),
    ("writes", "writes"),
    ("row_hits", "row hits"),
    ("row_misses", "row misses"),
    ("row_conflicts", "row conflicts"),
    ("bandwidth_bytes_per_cycle", "bytes a cycle"),
    ("bus_percent", "data bus busy %"),
)


class Phase(NamedTuple):
    """One phase of a run."""

    name: str  # e.g. izb_build
    values: dict[str, int | float]  # statistic's name without the phase -> value
    caches: list[str]  # names of its caches, nearest to the cores first
    units: tuple[str, ...] = ()  # names of its units, if it ran on a pipeline

    def stalls(self) -> dict[str, float]:
        """Share of issue slots by what became of them: `useful`, then each place to wait, in per cent."""
        places = {name: share for name, share in self._shares().items() if "." not in name}
        return {"useful": float(self.values["useful_percent"]), **places}

    def causes(self) -> dict[str, float]:
        """Share of issue slots by what they waited for, as `no_work` or `l2.mshr`, in per cent."""
        return _finest(self._shares())

    def _shares(self) -> dict[str, float]:
        return _stall_shares(self.values)


def _stall_shares(values: Mapping[str, int | float]) -> dict[str, float]:
    """Share of what each stall statistic names, in per cent."""
    return {
        name.removeprefix("stall.").removesuffix("_percent"): float(value)
        for name, value in values.items()
        if name.startswith("stall.")
    }


def _finest(shares: Mapping[str, float]) -> dict[str, float]:
    """Those that are not the sum of others: of a level its causes."""
    levels = {name.partition(".")[0] for name in shares if "." in name}
    return {name: share for name, share in shares.items() if name not in levels}


def unit_waits(result: Result) -> dict[str, dict[str, dict[str, float]]]:
    """phase -> unit -> share of the cycles by what the unit waited for, of pipelines."""
    return {
        phase: {unit: _finest(_waits(values)) for unit, values in units.items()}
        for phase, units in _values_of_units(result).items()
    }


def unit_cycles(result: Result) -> dict[str, dict[str, dict[str, float]]]:
    """phase -> unit -> share of its cycles: `busy`, then each place to wait, in per cent, of pipelines."""
    return {
        phase: {unit: _places(values) for unit, values in units.items()}
        for phase, units in _values_of_units(result).items()
    }


def _places(values: Mapping[str, int | float]) -> dict[str, float]:
    places = {name: share for name, share in _waits(values).items() if "." not in name}
    return {"busy": float(values["busy_percent"]), **places}


def _waits(values: Mapping[str, int | float]) -> dict[str, float]:
    """What a unit waited for, the sum of all memory left out."""
    return {name: share for name, share in _stall_shares(values).items() if name != "memory"}


def _values_of_units(result: Result) -> dict[str, dict[str, dict[str, int | float]]]:
    """phase -> unit -> its statistics by their last names, of pipelines."""
    found: dict[str, dict[str, dict[str, int | float]]] = {}
    for name in [s.name for s in result.statistics if s.name.endswith(".busy_percent")]:
        phase, _, unit = name.removesuffix(".busy_percent").rpartition(".")
        prefix = f"{phase}.{unit}."
        found.setdefault(phase, {})[unit] = {
            s.name.removeprefix(prefix): s.value for s in result.statistics if s.name.startswith(prefix)
        }
    return found


class Headline(NamedTuple):
    """A number that a person asks for first."""

    label: str
    value: int | float | str | bool
    unit: str
    description: str


def phases(result: Result) -> list[Phase]:
    """The phases in the order in which they ran: whatever has `useful_percent`."""
    names = [
        s.name.removesuffix(".useful_percent")
        for s in result.statistics
        if s.name.endswith(".useful_percent")
    ]
    return [_phase(result, name) for name in names]


def pipeline_phases(result: Result) -> list[Phase]:
    """The phases that ran on pipelines: whatever has units."""
    return [_phase(result, name) for name in unit_waits(result)]


def headlines(result: Result) -> list[Headline]:
    """The summary, with the unit and meaning of each number that is a statistic."""
    known = {statistic.name: statistic for statistic in result.statistics}
    nothing = Statistic("", 0, "", "")
    return [
        Headline(name, value, known.get(name, nothing).unit, known.get(name, nothing).description)
        for name, value in result.summary.items()
    ]


def _phase(result: Result, name: str) -> Phase:
    prefix = f"{name}."
    values = {s.name.removeprefix(prefix): s.value for s in result.statistics if s.name.startswith(prefix)}
    caches = [key.removesuffix(".hit_percent") for key in values if key.endswith(".hit_percent")]
    units = tuple(key.removesuffix(".busy_percent") for key in values if key.endswith(".busy_percent"))
    return Phase(name, values, caches, units)
