"""A timeline as a trace that Perfetto (ui.perfetto.dev) and chrome://tracing open."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

from archsim.machine.timeline import Timeline

_CORES, _CACHES, _CHANNELS = 1, 1001, 2001  # process numbers of the trace


def perfetto(timeline: Timeline, cache_names: Sequence[str], tick_hertz: int) -> str:
    """The trace as JSON: threads with tasks, slots and waits; caches with requests; banks with commands; queues."""
    microseconds = 1e6 / tick_hertz
    events = [*_names(timeline, cache_names), *_threads(timeline, cache_names)]
    events += [*_accesses(timeline, cache_names), *_commands(timeline), *_queues(timeline)]
    for event in events:
        for key in ("ts", "dur"):
            if key in event:
                event[key] = round(event[key] * microseconds, 6)
    return json.dumps({"traceEvents": events, "displayTimeUnit": "ns"})


def _names(timeline: Timeline, cache_names: Sequence[str]) -> Iterator[dict[str, Any]]:
    """What the tracks are called."""
    for core, thread in timeline.waits:
        yield _name("process_name", _CORES + core, 0, f"core {core}")
        yield _name("thread_name", _CORES + core, thread + 1, f"thread {thread}")
    for cache, name in enumerate(cache_names):
        yield _name("process_name", _CACHES + cache, 0, f"{name} (cache {cache})")
    for channel, bank in sorted({(command.channel, command.bank) for command in timeline.commands}):
        yield _name("process_name", _CHANNELS + channel, 0, f"DRAM channel {channel}")
        yield _name("thread_name", _CHANNELS + channel, bank + 1, f"bank {bank}")


def _name(what: str, process: int, thread: int, name: str) -> dict[str, Any]:
    return {"ph": "M", "name": what, "pid": process, "tid": thread, "args": {"name": name}}


def _threads(timeline: Timeline, cache_names: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Tasks, and in them what was issued and waited for."""
    period = timeline.spec.core.period_ticks
    for (core, thread), spans in timeline.tasks.items():
        for span in spans:
            yield _slice(_CORES + core, thread + 1, span.start, span.end - span.start, span.name)
    for (core, thread), spans in timeline.waits.items():
        for span in spans:
            name = f"wait for {_level(span.name, cache_names)}"
            yield _slice(_CORES + core, thread + 1, span.start, span.end - span.start, name)
    for slot in timeline.slots:
        yield _slice(_CORES + slot.core, slot.thread + 1, slot.tick, period, slot.op.lower())


def _level(name: str, cache_names: Sequence[str]) -> str:
    kind, _, index = name.partition(" ")
    return cache_names[int(index)] if kind == "cache" else name


def _slice(process: int, thread: int, start: int, ticks: int, name: str) -> dict[str, Any]:
    return {"ph": "X", "pid": process, "tid": thread, "ts": start, "dur": ticks, "name": name}


def _accesses(timeline: Timeline, cache_names: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Requests overlap, so each is a slice with a beginning and an end of its own."""
    levels = [*cache_names, "dram"]
    for number, access in enumerate(timeline.accesses):
        common = {
            "cat": "request",
            "id": number,
            "pid": _CACHES + access.cache,
            "tid": 1,
            "name": f"{access.kind} from {levels[access.supplier]}",
        }
        yield {**common, "ph": "b", "ts": access.start, "args": {"address": hex(access.address)}}
        yield {**common, "ph": "e", "ts": access.end}


def _commands(timeline: Timeline) -> Iterator[dict[str, Any]]:
    for command in timeline.commands:
        ticks = command.clocks * timeline.spec.dram.period_ticks
        name = f"{command.command} row {command.row}"
        yield _slice(_CHANNELS + command.channel, command.bank + 1, command.tick, ticks, name)


def _queues(timeline: Timeline) -> Iterator[dict[str, Any]]:
    for tick, channel, waiting in timeline.queues:
        yield {
            "ph": "C",
            "pid": _CHANNELS + channel,
            "ts": tick,
            "name": "requests waiting",
            "args": {"requests": waiting},
        }
