"""What the requests of the compiled machine waited for: what is noted of each, and how stalled cycles are charged.

README.md, *Where time goes*, has the rule. Little is noted: a request that is accepted as it comes leaves no trace but
the fetch that it joined, and what an earlier request of the same thread or MSHR left lies before the cycles charged.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.machine.counters import STALL_MEMORY
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.causes import AT_CACHE, AtCache, AtDram
from archsim.model.compiled import inlined_step, record, step
from archsim.model.dram.compiled_state import REQUEST_WAIT
from archsim.model.latency import NUM_CLASSES, class_of

IN_PARTS = 0xFFFFFFFF  # reason of a thread whose wait has several causes
LOOKUP_HIT = 0xFFFFFFFF  # `source` of what the lookup itself answered

_class_of = inlined_step(class_of)
_LOOKUP, _PORT = int(AtCache.LOOKUP), int(AtCache.PORT)
_QUEUE, _REFRESH, _ACTIVATION, _TURNAROUND, _BUS = (int(cause) for cause in AtDram)

_WAIT_FIELDS = (
    "refused_until",  # cycle behind the last one before `accepted` in which the cache refused a request
    "accepted",  # cycle in which the request was accepted, if not as it came; of a fetch in parts: the last of them
    "answered",  # cycle in which the last part so far came
    "asked",  # cycle in which the request came, if it was not answered at once
)
_WAIT_INDICES = (
    "lack",  # AtCache: what the refused request lacked
    "source",  # MSHR at the level that was asked, or LOOKUP_HIT
    "part",  # that `source` belongs to
)
WAIT = record(*_WAIT_FIELDS, indices=_WAIT_INDICES)


class WaitsState(NamedTuple):
    """K caches, M MSHRs a cache, N threads."""

    threads: np.ndarray  # WAIT [N] of the last request of a thread, at its cache
    fetches: np.ndarray  # WAIT [K, M] of the fetch of an MSHR, at the next level
    latencies: (
        np.ndarray
    )  # [K + 1, NUM_CLASSES] requests answered, by class; without those that hit as they came
    dram: (
        np.ndarray
    )  # REQUEST_WAIT [K + 1, M or more] of the same, at the DRAM; at last, of threads without cache


def new_waits(num_threads: int, mshrs: np.ndarray, are_threads_at_dram: bool) -> WaitsState:
    """Nothing has been asked yet. `mshrs`: [K, M]."""
    num_caches, num_mshrs = mshrs.shape
    width = max(num_mshrs, num_threads) if are_threads_at_dram else num_mshrs
    return WaitsState(
        threads=np.zeros(num_threads, WAIT),
        fetches=np.zeros((num_caches, num_mshrs), WAIT),
        latencies=np.zeros((num_caches + 1, NUM_CLASSES), np.int64),
        dram=np.zeros((num_caches + 1, width), REQUEST_WAIT),
    )


def all_latencies(waits: WaitsState, hit_cycles: np.ndarray, answered: np.ndarray) -> np.ndarray:
    """[K + 1, NUM_CLASSES] requests answered, by class. `hit_cycles`, `answered`: [K] requests, of the caches."""
    latencies = waits.latencies.copy()
    for cache, cycles in enumerate(hit_cycles.tolist()):
        latencies[cache, class_of(cycles)] += answered[cache] - latencies[cache].sum()
    return latencies


@inlined_step
def count_latency(state, level, cycles):
    """A request to this level was answered after so many cycles."""
    state.latencies[level, _class_of(cycles)] += 1


@inlined_step
def note_accepted(wait, owner, arrival, cycle):
    """The request that came in cycle `arrival` and had to wait is accepted in `cycle`."""
    wait["refused_until"] = owner["refused_until"] if owner["refused_until"] > arrival else arrival - 1
    wait["lack"] = owner["lack"]
    wait["accepted"] = cycle
    wait["source"] = LOOKUP_HIT


@inlined_step
def note_answered(wait, cycle, part, source):
    """A part of the fetch is answered in `cycle`; of those of one cycle the highest counts."""
    if wait["answered"] != cycle or part > wait["part"]:
        wait["answered"], wait["part"], wait["source"] = cycle, part, source


@step
def charge(spec, state, counts, slots, request):
    """Charge the slots from the first to before the second to what the thread's request waited for in them.

    `request`: thread and its cache, or the number of caches for the DRAM; answered in the cycle of the second slot.
    """
    (slot, end), (number, cache) = slots, request
    place, wait = (len(spec.caches), number), state.waits.threads[number]
    while cache != len(spec.caches):
        first_cause = STALL_MEMORY + AT_CACHE * cache
        slot = _charge_until(counts, slot, end, wait["refused_until"], first_cause + wait["lack"])
        slot = _charge_until(counts, slot, end, wait["accepted"], first_cause + _PORT)
        if wait["source"] == LOOKUP_HIT:
            counts[first_cause + _LOOKUP] += end - slot
            return
        place = cache, np.int64(wait["source"])
        slot = _charge_until(counts, slot, end, state.cache.mshrs[place]["arrival"], first_cause + _LOOKUP)
        wait = state.waits.fetches[place]
        parent = spec.caches[cache]["parent"]
        cache = len(spec.caches) if parent == DRAM_PARENT else parent
    _charge_dram(spec, counts, (slot, end), state.waits.dram[place])


@inlined_step
def _charge_dram(spec, counts, slots, wait):
    """The slots that are left went into the DRAM."""
    (slot, end), first = slots, STALL_MEMORY + AT_CACHE * len(spec.caches)
    if wait["column"] * spec.dram.period_ticks >= slot * spec.core.period_ticks:
        slot = _charge_until_clock(spec, counts, slot, end, wait["refreshing"], first + _QUEUE)
        slot = _charge_until_clock(spec, counts, slot, end, wait["refreshed"], first + _REFRESH)
        slot = _charge_until_clock(spec, counts, slot, end, wait["opening"], first + _QUEUE)
        slot = _charge_until_clock(spec, counts, slot, end, wait["opened"], first + _ACTIVATION)
        slot = _charge_until_clock(spec, counts, slot, end, wait["turning"], first + _QUEUE)
        slot = _charge_until_clock(spec, counts, slot, end, wait["turned"], first + _TURNAROUND)
        slot = _charge_until_clock(spec, counts, slot, end, wait["column"], first + _QUEUE)
    counts[first + _BUS] += end - slot


@inlined_step
def _charge_until_clock(spec, counts, slot, end, clock, cause):
    """Charge the slots up to the last one at whose tick the memory clock is still to come; most have none."""
    ticks = clock * spec.dram.period_ticks
    if ticks < slot * spec.core.period_ticks:
        return slot
    return _charge_until(counts, slot, end, ticks // spec.core.period_ticks, cause)


@inlined_step
def _charge_until(counts, slot, end, last, cause):
    """Charge the slots up to the last one, but before `end`, to the cause; returns the first one that is left."""
    behind = min(last + 1, end)
    if behind > slot:
        counts[cause] += behind - slot
        return behind
    return slot
