"""The statistics of a replayed address trace that a phase does not have."""

from __future__ import annotations

from archsim.model.cache.functional import LevelCounts
from archsim.run.measure import Measure, percent, ratio
from archsim.run.metrics import DramView
from archsim.trace.accesses import Kind

TRACE = [
    Measure("accesses", "accesses", "Lines of the trace.", lambda kinds: kinds.sum()),
    Measure("reads", "accesses", "Those that read data.", lambda kinds: kinds[Kind.READ]),
    Measure("writes", "accesses", "Those that write.", lambda kinds: kinds[Kind.WRITE]),
    Measure("fetches", "accesses", "Those that fetch instructions.", lambda kinds: kinds[Kind.FETCH]),
]
"""Of the number of accesses by kind."""


def _accesses(level: LevelCounts) -> int:
    return level.reads + level.writes


def _misses(level: LevelCounts) -> int:
    return level.read_misses + level.write_misses


LEVEL = [
    Measure(
        "accesses",
        "lookups",
        "Lookups; a request that crosses lines is one for each.",
        _accesses,
    ),
    Measure("reads", "lookups", "Read lookups, instruction fetches included.", lambda level: level.reads),
    Measure(
        "writes",
        "lookups",
        "Write lookups: stores, and write-backs and written-through stores from above.",
        lambda level: level.writes,
    ),
    Measure(
        "hits",
        "lookups",
        "Lookups that found what they touch.",
        lambda level: _accesses(level) - _misses(level),
    ),
    Measure("misses", "lookups", "Lookups that did not find all they touch.", _misses),
    Measure("read_misses", "lookups", "Reads among the misses.", lambda level: level.read_misses),
    Measure("write_misses", "lookups", "Writes among the misses.", lambda level: level.write_misses),
    Measure("fetches", "requests", "Reads sent to the next level.", lambda level: level.fetches),
    Measure(
        "writebacks",
        "requests",
        "Runs of dirty sectors sent to the next level; a line without sectors is one run.",
        lambda level: level.writebacks,
    ),
    Measure(
        "writethroughs",
        "requests",
        "Writes sent to the next level as they came.",
        lambda level: level.writethroughs,
    ),
    Measure(
        "hit_percent",
        "%",
        "Hits over accesses.",
        lambda level: percent(_accesses(level) - _misses(level), _accesses(level)),
    ),
    Measure("bytes_read", "bytes", "Bytes of the fetches.", lambda level: level.bytes_read),
    Measure(
        "bytes_written",
        "bytes",
        "Bytes of write-backs and written-through writes.",
        lambda level: level.bytes_written,
    ),
]
"""Of the LevelCounts of a cache without time."""

MEMORY = [
    Measure("requests", "requests", "Requests of the last cache.", _accesses),
    Measure("reads", "requests", "Fetches of the last cache.", lambda level: level.reads),
    Measure("writes", "requests", "Writes of the last cache.", lambda level: level.writes),
]
"""Of the LevelCounts of the memory behind caches without time."""

REPLAY = [
    Measure(
        "cycles",
        "cycles",
        "Core cycles until the last access was answered.",
        lambda view: view[0].counters.cycles,
    ),
    Measure(
        "cycles_per_access",
        "cycles",
        "Cycles over accesses.",
        lambda view: ratio(view[0].counters.cycles, view[1].sum()),
    ),
]
"""Of a PhaseView and the number of accesses by kind."""


def _seconds(view: DramView) -> float:
    return (
        view.phase.counters.cycles * view.phase.machine.spec.core.period_ticks / view.phase.machine.tick_hertz
    )


def _peak_bytes_per_second(view: DramView) -> float:
    spec = view.phase.machine.spec.dram
    clocks = view.phase.machine.tick_hertz / spec.period_ticks
    return clocks * 2 * spec.beat_bytes * spec.num_channels


TIMED_DRAM = [
    Measure(
        "gigabytes_per_second",
        "GB/s",
        "Bytes over the time until the last access was answered; 1 GB is 10^9 bytes.",
        lambda view: ratio(view.moved_bytes, 1e9 * _seconds(view)),
    ),
    Measure(
        "peak_gigabytes_per_second",
        "GB/s",
        "What all data buses carry if no clock is lost.",
        lambda view: _peak_bytes_per_second(view) / 1e9,
    ),
    Measure(
        "peak_percent",
        "%",
        "Gigabytes a second over the peak.",
        lambda view: percent(view.moved_bytes, _peak_bytes_per_second(view) * _seconds(view)),
    ),
]
"""Of the DramView of a replay with time."""
