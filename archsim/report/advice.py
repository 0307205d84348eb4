"""What limits a phase, in words, when that is clear from its statistics; every sentence has the number it rests on."""

from __future__ import annotations

from collections.abc import Mapping

from archsim.report.statistics import Phase

NEAR_PEAK = 80.0  # per cent of a resource's peak from which it is a limit
MANY_SLOTS = 15.0  # per cent of issue slots from which a reason to stall is worth a sentence
MANY_CYCLES = 20.0  # per cent of cycles in which a cache could not accept


def advice(phase: Phase) -> list[str]:
    """Sentences on a phase, the firmest first; one that says so where no limit is clear."""
    found = [
        *_issue(phase),
        *_bandwidth(phase),
        *_ports(phase),
        *_memory(phase),
        *_blocked(phase),
        *_others(phase),
    ]
    if found:
        return found
    largest = max(phase.stalls(), key=lambda reason: phase.stalls()[reason] if reason != "useful" else -1.0)
    share = phase.stalls()[largest]
    return [f"No single limit is clear; most empty slots, {share:.0f} %, wait for {_said(largest)}."]


def pipeline_advice(phase: Phase, waits: Mapping[str, Mapping[str, float]]) -> list[str]:
    """The same for a phase on a pipeline; `waits`: unit -> share of the cycles by what it waited for."""
    busy = {unit: float(phase.values[f"{unit}.busy_percent"]) for unit in phase.units}
    first = max(busy, key=lambda unit: busy[unit])
    found = [
        f"Limited by {unit}: it is busy in {share:.0f} % of the cycles. More lanes or a shorter interval help."
        for unit, share in busy.items()
        if share >= NEAR_PEAK
    ]
    found += [*_bandwidth(phase), *_ports(phase), *_blocked(phase)]
    if busy[first] < NEAR_PEAK and waits[first]:
        reason = max(waits[first], key=lambda cause: waits[first][cause])
        found.append(
            f"{first} is the busiest unit, with {busy[first]:.0f} % of the cycles; in {waits[first][reason]:.0f} % "
            f"it waits for {_said(reason.replace('.', ': '))}."
        )
    return found


def _issue(phase: Phase) -> list[str]:
    useful = phase.stalls()["useful"]
    if useful < NEAR_PEAK:
        return []
    return [
        f"Limited by issue: {useful:.0f} % of the slots issue an instruction. Only fewer instructions, "
        "more cores or a faster clock help; caches and DRAM can win at most the rest."
    ]


def _bandwidth(phase: Phase) -> list[str]:
    busy = float(phase.values.get("dram.bus_percent", 0.0))
    if busy < NEAR_PEAK:
        return []
    return [
        f"Limited by DRAM bandwidth: the data buses are busy {busy:.0f} % of the time. Fewer misses of the last "
        "cache, shorter lines or more channels help; more threads do not."
    ]


def _ports(phase: Phase) -> list[str]:
    shares = {cache: float(phase.values.get(f"{cache}.port_percent", 0.0)) for cache in phase.caches}
    return [
        f"Limited by the ports of {cache}: {share:.0f} % of its lookups are used. A second port, or a larger cache "
        "above it, helps."
        for cache, share in shares.items()
        if share >= NEAR_PEAK
    ]


def _memory(phase: Phase) -> list[str]:
    """Waiting for the DRAM while its buses have time: latency, not bandwidth."""
    waits, busy = phase.stalls().get("dram", 0.0), float(phase.values.get("dram.bus_percent", 0.0))
    if waits < MANY_SLOTS or busy >= NEAR_PEAK:
        return []
    text = (
        f"Limited by DRAM latency: {waits:.0f} % of the slots wait for the DRAM, whose buses are busy only "
        f"{busy:.0f} % of the time. More threads, more MSHRs or a larger last cache help; more channels little."
    )
    requests = sum(
        float(phase.values.get(f"dram.row_{kind}", 0.0)) for kind in ("hits", "misses", "conflicts")
    )
    conflicts = 100.0 * float(phase.values.get("dram.row_conflicts", 0.0)) / requests if requests else 0.0
    if conflicts >= 50.0:
        text += f" {conflicts:.0f} % of the requests meet another open row: try another address_map or page policy."
    return [text]


def _blocked(phase: Phase) -> list[str]:
    found = []
    for cache in phase.caches:
        blocked = float(phase.values.get(f"{cache}.blocked_cycles", 0.0))
        share = 100.0 * blocked / max(float(phase.values["cycles"]), 1.0)
        if share >= MANY_CYCLES:
            found.append(
                f"{cache} turned requests away in {share:.0f} % of the cycles, for want of an MSHR, a target or a "
                "way: try more of them."
            )
    return found


def _others(phase: Phase) -> list[str]:
    stalls, found = phase.stalls(), []
    if stalls.get("lock", 0.0) >= MANY_SLOTS:
        found.append(
            f"{stalls['lock']:.0f} % of the slots wait for locks: more locks, shorter critical sections or another "
            "order of the tasks help."
        )
    if stalls.get("no_work", 0.0) >= MANY_SLOTS:
        found.append(
            f"{stalls['no_work']:.0f} % of the slots have no work: the source is too slow, or the last tasks leave "
            "cores idle."
        )
    caches = {cache: stalls.get(cache, 0.0) for cache in phase.caches[1:]}
    found += [
        f"{share:.0f} % of the slots wait for {cache}: a larger cache above it, or a shorter hit time, helps."
        for cache, share in caches.items()
        if share >= MANY_SLOTS
    ]
    return found


def _said(reason: str) -> str:
    return {
        "no_work": "a task",
        "lock": "a lock",
        "dram": "the DRAM",
        "output": "room behind it",
        "pool": "a free buffer",
        "latency": "its own latency",
        "delay_stream": "the delay stream",
    }.get(reason, reason)
