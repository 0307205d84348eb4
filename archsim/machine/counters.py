"""What both models return: every counter once, in plain integer arrays, so that equality means equal."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from archsim.machine.spec import MachineSpec
from archsim.model.causes import num_causes
from archsim.model.latency import NUM_CLASSES

# Why an issue slot was empty. Behind these come the causes of waits for memory: STALL_MEMORY + number (model/causes).
STALL_NO_WORK = 0
STALL_LOCK = 1
STALL_MEMORY = 2


class Counters(NamedTuple):
    """Counters of one phase. [C] cores, [K] caches, [H] DRAM channels; README.md says when things happen."""

    cycles: int  # core cycles until the last task was finished
    useful: np.ndarray  # [C] issue slots in which an instruction was issued
    stalled: np.ndarray  # [C, STALL_MEMORY + causes] empty issue slots by cause
    tasks: np.ndarray  # [C] tasks finished
    emitted: np.ndarray  # [C] EMIT operations
    locks_taken: int  # LOCK operations granted
    locks_waited: int  # LOCK operations that found the lock held
    lock_wait_ticks: int  # ticks between asking and grant, summed over those
    drained_cycles: int  # core cycles, rounded up, until nothing was on its way any more
    latencies: (
        np.ndarray
    )  # [K + 1, NUM_CLASSES] requests answered at each cache and the DRAM, by class of latency
    cache_reads: np.ndarray  # [K] read lookups (LOAD, or a child's fetch) that were accepted
    cache_writes: np.ndarray  # [K] write lookups (STORE) that were accepted
    cache_writebacks_in: np.ndarray  # [K] writes from children, back or through, that were accepted
    cache_clears: np.ndarray  # [K] CLEARs that were accepted
    cache_hits: np.ndarray  # [K] accepted lookups of any kind that found their bytes present
    cache_merges: np.ndarray  # [K] accepted lookups of any kind that found their bytes on their way
    cache_misses: np.ndarray  # [K] accepted lookups of any kind that found neither
    cache_clear_fills: np.ndarray  # [K] misses filled without a fetch because memory was known to be cleared
    cache_fetches: np.ndarray  # [K] reads sent to the next level
    cache_writebacks_out: np.ndarray  # [K] writes of victims sent to the next level
    cache_writethroughs_out: np.ndarray  # [K] other writes sent to the next level
    cache_fetched_bytes: np.ndarray  # [K] bytes of the reads sent to the next level
    cache_written_bytes: np.ndarray  # [K] bytes of the writes sent to the next level
    cache_blocked: np.ndarray  # [K] cycles in which the oldest waiting request could not be accepted
    cache_fetch_ticks: np.ndarray  # [K] ticks from a fetch reaching the next level to its fill, summed
    dram_reads: np.ndarray  # [H] read requests whose column command was issued
    dram_writes: np.ndarray  # [H] write requests whose column command was issued
    dram_forwarded: np.ndarray  # [H] reads answered by a write that waited in the write queue
    dram_forwarded_bytes: np.ndarray  # [H] their bytes
    dram_row_hits: np.ndarray  # [H] requests whose row was open when first considered
    dram_row_misses: np.ndarray  # [H] requests whose bank was closed when first considered
    dram_row_conflicts: np.ndarray  # [H] requests that met another open row when first considered
    dram_activates: np.ndarray  # [H] ACT commands
    dram_precharges: np.ndarray  # [H] PRE commands (a precharge-all counts once)
    dram_refreshes: np.ndarray  # [H] REF commands
    dram_data_clocks: np.ndarray  # [H] memory clocks in which the data bus carried data
    dram_waited_clocks: (
        np.ndarray
    )  # [H] memory clocks from arrival to column command or forwarding, of all requests
    dram_read_queue_clocks: np.ndarray  # [H] memory clocks that reads waited for others, summed over reads
    dram_read_refresh_clocks: np.ndarray  # [H] that they waited for a refresh
    dram_read_activation_clocks: np.ndarray  # [H] that they waited for their row to be opened
    dram_read_turnaround_clocks: (
        np.ndarray
    )  # [H] that they waited for the bus to turn from writing to reading
    dram_read_bus_clocks: np.ndarray  # [H] from their column command to their last data


def no_counters(spec: MachineSpec) -> Counters:
    """Counters of a run in which nothing happened."""
    num_cores, num_caches = spec.core.num_cores, len(spec.caches)
    shapes: dict[str, tuple[int, ...]] = {
        "useful": (num_cores,),
        "stalled": (num_cores, STALL_MEMORY + num_causes(num_caches)),
        "tasks": (num_cores,),
        "emitted": (num_cores,),
        "latencies": (num_caches + 1, NUM_CLASSES),
    }
    values: dict[str, Any] = {}
    for name in Counters._fields:
        if name.startswith("cache_"):
            values[name] = np.zeros(num_caches, np.int64)
        elif name.startswith("dram_"):
            values[name] = np.zeros(spec.dram.num_channels, np.int64)
        else:
            values[name] = np.zeros(shapes[name], np.int64) if name in shapes else 0
    return Counters(**values)


def added(a: Counters, b: Counters) -> Counters:
    """Two phases on the same machine, one after the other."""
    sums: dict[str, Any] = {name: getattr(a, name) + getattr(b, name) for name in Counters._fields}
    return Counters(**sums)


def without_cores(cycles: int, drained_cycles: int, memory: dict[str, np.ndarray]) -> Counters:
    """Counters of a machine that has no cores: those of its caches and DRAM by name."""
    none = np.zeros(0, np.int64)
    cores: dict[str, Any] = dict.fromkeys(("useful", "stalled", "tasks", "emitted"), none)
    locks: dict[str, Any] = dict.fromkeys(("locks_taken", "locks_waited", "lock_wait_ticks"), 0)
    values: dict[str, Any] = {**cores, **locks, **memory}
    return Counters(cycles=cycles, drained_cycles=drained_cycles, **values)
