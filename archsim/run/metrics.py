"""Counters of a phase as named statistics, and the laws they obey. Ratios of counters are made here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.machine.build import PhaseMachine
from archsim.machine.counters import STALL_LOCK, STALL_MEMORY, STALL_NO_WORK, Counters
from archsim.model.cache.spec import DRAM_PARENT, CacheSpec
from archsim.run.latency_metrics import LATENCIES, latencies_of
from archsim.run.measure import Measure, measured, percent, ratio
from archsim.run.result import Check, Statistic
from archsim.run.stall_metrics import stall_statistics


class PhaseView(NamedTuple):
    """A phase that was played."""

    machine: PhaseMachine
    counters: Counters

    @property
    def slots(self) -> int:
        """Issue slots of all cores."""
        return self.counters.cycles * self.machine.spec.core.num_cores

    def stalled(self, cause: int) -> int:
        """Empty issue slots of all cores with that cause."""
        return int(self.counters.stalled[:, cause].sum())

    def cycles_of(self, ticks: float) -> float:
        """Core cycles in a number of ticks."""
        return ticks / self.machine.spec.core.period_ticks


class CacheView(NamedTuple):
    """The caches of one name together."""

    phase: PhaseView
    members: list[int]  # indices of the caches

    def total(self, counter: str) -> int:
        """A counter's sum over these caches."""
        return int(getattr(self.phase.counters, f"cache_{counter}")[self.members].sum())

    @property
    def latencies(self) -> np.ndarray:
        """Requests answered by class of latency."""
        counts: np.ndarray = self.phase.counters.latencies[self.members].sum(axis=0)
        return counts

    @property
    def accesses(self) -> int:
        """Accepted lookups of any kind."""
        return self.total("reads") + self.total("writes") + self.total("writebacks_in")

    @property
    def specs(self) -> list[CacheSpec]:
        return [self.phase.machine.spec.caches[index] for index in self.members]


class DramView(NamedTuple):
    """All DRAM channels together."""

    phase: PhaseView

    def total(self, counter: str) -> int:
        """A counter's sum over the channels."""
        return int(getattr(self.phase.counters, f"dram_{counter}").sum())

    @property
    def latencies(self) -> np.ndarray:
        """Requests answered by class of latency, in core cycles."""
        counts: np.ndarray = self.phase.counters.latencies[-1]
        return counts

    @property
    def moved_bytes(self) -> int:
        dram = self.phase.machine.spec.dram
        return self.total("data_clocks") * dram.clock_beats * dram.beat_bytes

    @property
    def bus_clocks(self) -> float:
        """Memory clocks in `cycles`, summed over the channels' data buses."""
        spec = self.phase.machine.spec
        clocks = self.phase.counters.cycles * spec.core.period_ticks / spec.dram.period_ticks
        return clocks * spec.dram.num_channels


CORES = [
    Measure(
        "cycles", "cycles", "Core cycles until the last task was finished.", lambda view: view.counters.cycles
    ),
    Measure(
        "drained_cycles",
        "cycles",
        "The same, rounded up, until nothing was on its way in caches and DRAM either.",
        lambda view: view.counters.drained_cycles,
    ),
    Measure(
        "instructions",
        "instructions",
        "Issue slots in which an instruction was issued.",
        lambda view: view.counters.useful.sum(),
    ),
    Measure("tasks", "tasks", "Tasks finished.", lambda view: view.counters.tasks.sum()),
    Measure("emitted", "items", "EMIT operations.", lambda view: view.counters.emitted.sum()),
    Measure(
        "useful_percent",
        "%",
        "Share of issue slots that were used.",
        lambda view: percent(view.counters.useful.sum(), view.slots),
    ),
    Measure(
        "frames_per_second",
        "frames/s",
        "Core clock frequency over cycles: the rate if a frame were this phase alone.",
        lambda view: ratio(view.cycles_of(view.machine.tick_hertz), view.counters.cycles),
    ),
    Measure(
        "stall.no_work_percent",
        "%",
        "Slots empty for want of tasks.",
        lambda view: percent(view.stalled(STALL_NO_WORK), view.slots),
    ),
    Measure(
        "stall.lock_percent",
        "%",
        "Slots empty while waiting for a lock.",
        lambda view: percent(view.stalled(STALL_LOCK), view.slots),
    ),
]

LOCKS = [
    Measure("taken", "grants", "LOCK operations granted.", lambda view: view.counters.locks_taken),
    Measure(
        "waited",
        "grants",
        "LOCK operations that found the lock held.",
        lambda view: view.counters.locks_waited,
    ),
    Measure(
        "average_wait_cycles",
        "cycles",
        "Cycles from asking to grant, over the LOCKs that waited.",
        lambda view: ratio(view.cycles_of(view.counters.lock_wait_ticks), view.counters.locks_waited),
    ),
]

CACHES = [
    Measure(
        "accesses",
        "lookups",
        "Accepted lookups: reads, writes, and writes from children.",
        lambda view: view.accesses,
    ),
    Measure(
        "reads", "lookups", "Read lookups: loads or a child's fetches.", lambda view: view.total("reads")
    ),
    Measure("writes", "lookups", "Write lookups: stores.", lambda view: view.total("writes")),
    Measure(
        "writebacks_in",
        "lookups",
        "Writes from children: their dirty victims, and writes that they passed on.",
        lambda view: view.total("writebacks_in"),
    ),
    Measure("clears", "lookups", "CLEAR operations.", lambda view: view.total("clears")),
    Measure("hits", "lookups", "Lookups that found their bytes present.", lambda view: view.total("hits")),
    Measure(
        "merges", "lookups", "Lookups that found their bytes on their way.", lambda view: view.total("merges")
    ),
    Measure("misses", "lookups", "Lookups that found neither.", lambda view: view.total("misses")),
    Measure(
        "clear_fills",
        "lookups",
        "Misses filled without a fetch because memory was known to be cleared.",
        lambda view: view.total("clear_fills"),
    ),
    Measure("fetches", "requests", "Reads sent to the next level.", lambda view: view.total("fetches")),
    Measure(
        "writebacks",
        "requests",
        "Writes of dirty victims sent to the next level.",
        lambda view: view.total("writebacks_out"),
    ),
    Measure(
        "writethroughs",
        "requests",
        "Other writes sent to the next level.",
        lambda view: view.total("writethroughs_out"),
    ),
    Measure(
        "fetched_bytes",
        "bytes",
        "Bytes of the reads sent to the next level.",
        lambda view: view.total("fetched_bytes"),
    ),
    Measure(
        "written_bytes",
        "bytes",
        "Bytes of the writes sent to the next level.",
        lambda view: view.total("written_bytes"),
    ),
    Measure(
        "hit_percent",
        "%",
        "Hits over accesses.",
        lambda view: percent(view.total("hits"), view.accesses),
    ),
    Measure(
        "port_percent",
        "%",
        "Accesses over what the ports could take in `cycles`.",
        lambda view: percent(
            view.accesses, view.phase.counters.cycles * sum(spec.num_ports for spec in view.specs)
        ),
    ),
    Measure(
        "blocked_cycles",
        "cycles",
        "Cycles in which the oldest request could not be accepted.",
        lambda view: view.total("blocked"),
    ),
    Measure(
        "average_miss_cycles",
        "cycles",
        "Cycles from a fetch reaching the next level to its fill, averaged over fetches: "
        "time spent below this level.",
        lambda view: ratio(view.phase.cycles_of(view.total("fetch_ticks")), view.total("fetches")),
    ),
    *LATENCIES,
]

DRAM = [
    Measure(
        "requests",
        "requests",
        "Line requests served.",
        lambda view: view.total("reads") + view.total("writes"),
    ),
    Measure("reads", "requests", "Read requests served.", lambda view: view.total("reads")),
    Measure("writes", "requests", "Write requests served.", lambda view: view.total("writes")),
    Measure(
        "forwarded",
        "requests",
        "Reads answered by a write that waited in the write queue; not among those served.",
        lambda view: view.total("forwarded"),
    ),
    Measure("forwarded_bytes", "bytes", "Bytes of those reads.", lambda view: view.total("forwarded_bytes")),
    Measure(
        "row_hits",
        "requests",
        "Requests whose row was open when first considered.",
        lambda view: view.total("row_hits"),
    ),
    Measure(
        "row_misses",
        "requests",
        "Requests whose bank was closed when first considered.",
        lambda view: view.total("row_misses"),
    ),
    Measure(
        "row_conflicts",
        "requests",
        "Requests that met another open row when first considered.",
        lambda view: view.total("row_conflicts"),
    ),
    Measure("activates", "commands", "ACT commands.", lambda view: view.total("activates")),
    Measure(
        "precharges",
        "commands",
        "PRE commands; one for all banks counts once.",
        lambda view: view.total("precharges"),
    ),
    Measure("refreshes", "commands", "REF commands.", lambda view: view.total("refreshes")),
    Measure("bytes", "bytes", "Bytes carried by the data buses.", lambda view: view.moved_bytes),
    Measure(
        "read_queue_clocks",
        "clocks",
        "Memory clocks that reads waited for other requests, summed over the reads.",
        lambda view: view.total("read_queue_clocks"),
    ),
    Measure(
        "read_refresh_clocks",
        "clocks",
        "Memory clocks that reads waited for a refresh, summed over the reads.",
        lambda view: view.total("read_refresh_clocks"),
    ),
    Measure(
        "read_activation_clocks",
        "clocks",
        "Memory clocks that reads waited for their row to be opened, summed over the reads.",
        lambda view: view.total("read_activation_clocks"),
    ),
    Measure(
        "read_turnaround_clocks",
        "clocks",
        "Memory clocks that reads waited for the bus to turn from writing to reading, summed over the reads.",
        lambda view: view.total("read_turnaround_clocks"),
    ),
    Measure(
        "read_bus_clocks",
        "clocks",
        "Memory clocks from reads' column commands to their last data, summed over the reads.",
        lambda view: view.total("read_bus_clocks"),
    ),
    Measure(
        "waited_clocks",
        "clocks",
        "Memory clocks from arrival to column command or forwarding, summed over all requests.",
        lambda view: view.total("waited_clocks"),
    ),
    Measure(
        "bandwidth_bytes_per_cycle",
        "bytes/cycle",
        "Bytes over core cycles.",
        lambda view: ratio(view.moved_bytes, view.phase.counters.cycles),
    ),
    Measure(
        "bus_percent",
        "%",
        "Clocks in which a data bus carried data over those in `cycles`.",
        lambda view: percent(view.total("data_clocks"), view.bus_clocks),
    ),
    *LATENCIES,
]


def phase_statistics(phase: str, machine: PhaseMachine, counters: Counters) -> list[Statistic]:
    """Every counter of a phase and the ratios made of them, named `phase.component.what`."""
    view = PhaseView(machine, counters)
    found = measured(phase, CORES, view)
    waited = counters.stalled[:, STALL_MEMORY:].sum(axis=0)
    found += stall_statistics(phase, by_name([*machine.cache_names, "dram"]), waited, view.slots)
    found += measured(f"{phase}.locks", LOCKS, view)
    return found + memory_statistics(phase, machine, counters)


def memory_statistics(phase: str, machine: PhaseMachine, counters: Counters) -> list[Statistic]:
    """The counters of caches and DRAM and the ratios made of them."""
    view, found = PhaseView(machine, counters), []
    for cache, members in by_name(machine.cache_names).items():
        found += measured(f"{phase}.{cache}", CACHES, CacheView(view, members))
    return found + measured(f"{phase}.dram", DRAM, DramView(view))


def by_name(names: Sequence[str]) -> dict[str, list[int]]:
    """Indices of each name, in the order of first appearance."""
    return {name: [k for k, other in enumerate(names) if other == name] for name in dict.fromkeys(names)}


def phase_latencies(phase: str, machine: PhaseMachine, counters: Counters) -> dict[str, np.ndarray]:
    """Requests by class of latency, for every level of a phase's machine."""
    return latencies_of(phase, by_name([*machine.cache_names, "dram"]), counters.latencies)


def phase_checks(phase: str, machine: PhaseMachine, counters: Counters) -> list[Check]:
    """The conservation laws of a phase."""
    spec = machine.spec
    lookups = counters.cache_reads + counters.cache_writes + counters.cache_writebacks_in
    answered = counters.cache_reads + counters.cache_writes + counters.cache_clears
    outcomes = counters.cache_hits + counters.cache_merges + counters.cache_misses
    writes_out = counters.cache_writebacks_out + counters.cache_writethroughs_out
    bytes_out = counters.cache_fetched_bytes + counters.cache_written_bytes
    last = [k for k, cache in enumerate(spec.caches) if cache.parent == DRAM_PARENT]
    requests = counters.dram_reads + counters.dram_writes
    classified = counters.dram_row_hits + counters.dram_row_misses + counters.dram_row_conflicts
    carried = int(counters.dram_data_clocks.sum()) * spec.dram.clock_beats * spec.dram.beat_bytes
    read = counters.dram_reads.sum() + counters.dram_forwarded.sum()
    laws = [
        (
            "slots",
            counters.useful + counters.stalled.sum(axis=1),
            np.full(spec.core.num_cores, counters.cycles),
        ),
        ("lookups", lookups, outcomes),
        ("fetches reach the DRAM", counters.cache_fetches[last].sum(), read),
        ("writes reach the DRAM", writes_out[last].sum(), counters.dram_writes.sum()),
        ("DRAM bytes", bytes_out[last].sum() - counters.dram_forwarded_bytes.sum(), carried),
        ("row outcomes", requests, classified),
        ("latencies at caches", counters.latencies[:-1].sum(axis=1), answered),
        ("latencies at the DRAM", counters.latencies[-1].sum(), read),
    ]
    for k in range(len(spec.caches)):
        children = [child for child, cache in enumerate(spec.caches) if cache.parent == k]
        if children:
            sent = writes_out[children].sum()
            laws.append((f"writes into cache {k}", sent, counters.cache_writebacks_in[k]))
            laws.append(
                (f"fetches from cache {k}", counters.cache_fetches[children].sum(), counters.cache_reads[k])
            )
    return [equal(f"{phase}: {name}", left, right) for name, left, right in laws]


def equal(name: str, left: np.ndarray | int, right: np.ndarray | int) -> Check:
    """The law that two counts are equal."""
    return Check(name, bool(np.array_equal(left, right)), f"{_plain(left)} = {_plain(right)}")


def _plain(value: np.ndarray | int) -> str:
    return str(np.asarray(value).tolist())
