"""Counters of a phase as named statistics, and the laws they obey. Ratios of counters are made here."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from archsim.machine.build import PhaseMachine
from archsim.machine.counters import STALL_LOCK, STALL_NO_WORK, STALL_SUPPLIER, Counters
from archsim.model.cache.spec import DRAM_PARENT
from archsim.run.result import Check, Statistic


def ratio(part: float, whole: float) -> float:
    """part / whole, 0 when there is no whole."""
    return float(part) / float(whole) if whole else 0.0


def percent(part: float, whole: float) -> float:
    return 100.0 * ratio(part, whole)


def phase_statistics(phase: str, machine: PhaseMachine, counters: Counters) -> list[Statistic]:
    """Every counter of a phase and the ratios made of them, named `phase.component.what`."""
    rows: list[Statistic] = []

    def add(name: str, value: float, unit: str, description: str) -> None:
        number = int(value) if isinstance(value, int | np.integer) else float(value)
        rows.append(Statistic(f"{phase}.{name}", number, unit, description))

    _core_statistics(machine, counters, add)
    for name in dict.fromkeys(machine.cache_names):
        _cache_statistics(machine, counters, name, add)
    _dram_statistics(machine, counters, add)
    return rows


Add = Callable[[str, float, str, str], None]


def _core_statistics(machine: PhaseMachine, counters: Counters, add: Add) -> None:
    spec = machine.spec
    slots = counters.cycles * spec.core.num_cores
    frequency = machine.tick_hertz / spec.core.period_ticks
    add("cycles", counters.cycles, "cycles", "Core cycles until the last task was finished.")
    add(
        "instructions",
        counters.useful.sum(),
        "instructions",
        "Issue slots in which an instruction was issued.",
    )
    add("tasks", counters.tasks.sum(), "tasks", "Tasks finished.")
    add("emitted", counters.emitted.sum(), "items", "EMIT operations.")
    add("useful_percent", percent(counters.useful.sum(), slots), "%", "Share of issue slots that were used.")
    add(
        "frames_per_second",
        ratio(frequency, counters.cycles),
        "frames/s",
        "Core clock frequency over cycles: the rate if a frame were this phase alone.",
    )
    stalled = counters.stalled.sum(axis=0)
    add(
        "stall.no_work_percent", percent(stalled[STALL_NO_WORK], slots), "%", "Slots empty for want of tasks."
    )
    add(
        "stall.lock_percent",
        percent(stalled[STALL_LOCK], slots),
        "%",
        "Slots empty while waiting for a lock.",
    )
    suppliers = [*machine.cache_names, "dram"]
    for name in dict.fromkeys(suppliers):
        empty = sum(int(stalled[STALL_SUPPLIER + k]) for k, other in enumerate(suppliers) if other == name)
        add(
            f"stall.{name}_percent",
            percent(empty, slots),
            "%",
            f"Slots empty while waiting for a line from {name}.",
        )
    add("locks.taken", counters.locks_taken, "grants", "LOCK operations granted.")
    add("locks.waited", counters.locks_waited, "grants", "LOCK operations that found the lock held.")
    waited = ratio(counters.lock_wait_ticks / spec.core.period_ticks, counters.locks_waited)
    add(
        "locks.average_wait_cycles",
        waited,
        "cycles",
        "Cycles from asking to grant, over the LOCKs that waited.",
    )


def _cache_statistics(machine: PhaseMachine, counters: Counters, name: str, add: Add) -> None:
    own = [index for index, other in enumerate(machine.cache_names) if other == name]

    def total(counter: np.ndarray) -> int:
        return int(counter[own].sum())

    accesses = (
        total(counters.cache_reads) + total(counters.cache_writes) + total(counters.cache_writebacks_in)
    )
    fetches = total(counters.cache_fetches)
    add(
        f"{name}.accesses",
        accesses,
        "lookups",
        "Accepted lookups: reads, writes and write-backs from children.",
    )
    add(f"{name}.reads", total(counters.cache_reads), "lookups", "Read lookups: loads or a child's fetches.")
    add(f"{name}.writes", total(counters.cache_writes), "lookups", "Write lookups: stores.")
    add(f"{name}.writebacks_in", total(counters.cache_writebacks_in), "lookups", "Write-backs from children.")
    add(f"{name}.hits", total(counters.cache_hits), "lookups", "Lookups that found their line present.")
    add(
        f"{name}.merges", total(counters.cache_merges), "lookups", "Lookups that found their line on its way."
    )
    add(f"{name}.misses", total(counters.cache_misses), "lookups", "Lookups that found no line.")
    add(f"{name}.fetches", fetches, "lines", "Lines fetched from the next level.")
    add(
        f"{name}.writebacks",
        total(counters.cache_writebacks_out),
        "lines",
        "Dirty victims sent to the next level.",
    )
    add(f"{name}.hit_percent", percent(total(counters.cache_hits), accesses), "%", "Hits over accesses.")
    lookups = counters.cycles * sum(machine.spec.caches[index].num_ports for index in own)
    add(
        f"{name}.port_percent",
        percent(accesses, lookups),
        "%",
        "Accesses over what the ports could take in `cycles`.",
    )
    blocked = total(counters.cache_blocked)
    add(
        f"{name}.blocked_cycles",
        blocked,
        "cycles",
        "Cycles in which the oldest request could not be accepted.",
    )
    below = ratio(total(counters.cache_fetch_ticks) / machine.spec.core.period_ticks, fetches)
    add(
        f"{name}.average_miss_cycles",
        below,
        "cycles",
        "Cycles from a fetch reaching the next level to its fill, averaged over fetches: time spent below this level.",
    )


def _dram_statistics(machine: PhaseMachine, counters: Counters, add: Add) -> None:
    spec = machine.spec
    reads, writes = int(counters.dram_reads.sum()), int(counters.dram_writes.sum())
    moved = int(counters.dram_data_clocks.sum()) * 2 * spec.dram.beat_bytes
    clocks = counters.cycles * spec.core.period_ticks / spec.dram.period_ticks
    add("dram.requests", reads + writes, "requests", "Line requests served.")
    add("dram.reads", reads, "requests", "Read requests served.")
    add("dram.writes", writes, "requests", "Write requests served.")
    add(
        "dram.row_hits",
        counters.dram_row_hits.sum(),
        "requests",
        "Requests whose row was open when first considered.",
    )
    add("dram.row_misses", counters.dram_row_misses.sum(), "requests", "Requests whose bank was closed then.")
    add(
        "dram.row_conflicts",
        counters.dram_row_conflicts.sum(),
        "requests",
        "Requests that met another open row.",
    )
    add("dram.activates", counters.dram_activates.sum(), "commands", "ACT commands.")
    add(
        "dram.precharges",
        counters.dram_precharges.sum(),
        "commands",
        "PRE commands; one for all banks counts once.",
    )
    add("dram.refreshes", counters.dram_refreshes.sum(), "commands", "REF commands.")
    add("dram.bytes", moved, "bytes", "Bytes carried by the data buses.")
    add(
        "dram.bandwidth_bytes_per_cycle",
        ratio(moved, counters.cycles),
        "bytes/cycle",
        "Bytes over core cycles.",
    )
    busy = percent(counters.dram_data_clocks.sum(), clocks * spec.dram.num_channels)
    add(
        "dram.bus_percent",
        busy,
        "%",
        "Clocks in which a data bus carried data over those in `cycles`.",
    )


def phase_checks(phase: str, machine: PhaseMachine, counters: Counters) -> list[Check]:
    """The conservation laws of a phase."""
    spec = machine.spec
    line = spec.caches[-1].line_bytes
    lookups = counters.cache_reads + counters.cache_writes + counters.cache_writebacks_in
    outcomes = counters.cache_hits + counters.cache_merges + counters.cache_misses
    last = [k for k, cache in enumerate(spec.caches) if cache.parent == DRAM_PARENT]
    requests = counters.dram_reads + counters.dram_writes
    classified = counters.dram_row_hits + counters.dram_row_misses + counters.dram_row_conflicts
    carried = int(counters.dram_data_clocks.sum()) * 2 * spec.dram.beat_bytes
    laws = [
        (
            "slots",
            counters.useful + counters.stalled.sum(axis=1),
            np.full(spec.core.num_cores, counters.cycles),
        ),
        ("lookups", lookups, outcomes),
        ("fetches reach the DRAM", counters.cache_fetches[last].sum(), counters.dram_reads.sum()),
        ("write-backs reach the DRAM", counters.cache_writebacks_out[last].sum(), counters.dram_writes.sum()),
        ("DRAM bytes", requests.sum() * line, carried),
        ("row outcomes", requests, classified),
    ]
    for k in range(len(spec.caches)):
        children = [child for child, cache in enumerate(spec.caches) if cache.parent == k]
        if children:
            sent = counters.cache_writebacks_out[children].sum()
            laws.append((f"write-backs into cache {k}", sent, counters.cache_writebacks_in[k]))
            laws.append(
                (f"fetches from cache {k}", counters.cache_fetches[children].sum(), counters.cache_reads[k])
            )
    return [_equal(f"{phase}: {name}", left, right) for name, left, right in laws]


def _equal(name: str, left: np.ndarray | int, right: np.ndarray | int) -> Check:
    return Check(name, bool(np.array_equal(left, right)), f"{_plain(left)} = {_plain(right)}")


def _plain(value: np.ndarray | int) -> str:
    return str(np.asarray(value).tolist())
