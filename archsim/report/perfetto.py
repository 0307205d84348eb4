"""A timeline as a trace that Perfetto (ui.perfetto.dev) and chrome://tracing open."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from archsim.machine.timeline import Timeline

_CORES, _CACHES, _CHANNELS, _BETWEEN = 1, 1001, 2001, 3001  # process numbers of the trace


class Labels(NamedTuple):
    """What the parts of a machine are called."""

    caches: Sequence[str]
    tick_hertz: int
    units: Sequence[str] = ()  # of a pipeline
    channels: Sequence[str] = ()  # its fifos, then its delay streams; of cores the fifo before them


def perfetto(timeline: Timeline, labels: Labels) -> str:
    """The trace as JSON: threads or units with tasks, slots and waits; requests, DRAM commands, queues."""
    microseconds = 1e6 / labels.tick_hertz
    events = [*_names(timeline, labels), *_threads(timeline, labels)]
    events += [
        *_accesses(timeline, labels),
        *_commands(timeline),
        *_queues(timeline),
        *_held(timeline, labels),
    ]
    for event in events:
        for key in ("ts", "dur"):
            if key in event:
                event[key] = round(event[key] * microseconds, 6)
    return json.dumps({"traceEvents": events, "displayTimeUnit": "ns"})


def _names(timeline: Timeline, labels: Labels) -> Iterator[dict[str, Any]]:
    """What the tracks are called."""
    for core, thread in timeline.waits:
        is_unit = len(labels.units) > 0
        yield _name("process_name", _CORES + core, 0, labels.units[core] if is_unit else f"core {core}")
        yield _name("thread_name", _CORES + core, thread + 1, "front" if is_unit else f"thread {thread}")
    for cache, name in enumerate(labels.caches):
        yield _name("process_name", _CACHES + cache, 0, f"{name} (cache {cache})")
    if timeline.held:
        what = "fifos (items) and delay streams (bytes)" if labels.units else "fifo (tasks)"
        yield _name("process_name", _BETWEEN, 0, what)
    for channel, bank in sorted({(command.channel, command.bank) for command in timeline.commands}):
        yield _name("process_name", _CHANNELS + channel, 0, f"DRAM channel {channel}")
        yield _name("thread_name", _CHANNELS + channel, bank + 1, f"bank {bank}")


def _name(what: str, process: int, thread: int, name: str) -> dict[str, Any]:
    return {"ph": "M", "name": what, "pid": process, "tid": thread, "args": {"name": name}}


def _threads(timeline: Timeline, labels: Labels) -> Iterator[dict[str, Any]]:
    """Tasks, and in them what was issued and waited for."""
    period = timeline.period_ticks
    for (core, thread), spans in timeline.tasks.items():
        for span in spans:
            yield _slice(_CORES + core, thread + 1, span.start, span.end - span.start, span.name)
    for (core, thread), spans in timeline.waits.items():
        for span in spans:
            name = span.name if labels.units else f"wait for {_level(span.name, labels.caches)}"
            yield _slice(_CORES + core, thread + 1, span.start, span.end - span.start, name)
    for slot in timeline.slots:
        yield _slice(_CORES + slot.core, slot.thread + 1, slot.tick, period, slot.op.lower())


def _level(name: str, cache_names: Sequence[str]) -> str:
    kind, _, index = name.partition(" ")
    return cache_names[int(index)] if kind == "cache" else name


def _slice(process: int, thread: int, start: int, ticks: int, name: str) -> dict[str, Any]:
    return {"ph": "X", "pid": process, "tid": thread, "ts": start, "dur": ticks, "name": name}


def _accesses(timeline: Timeline, labels: Labels) -> Iterator[dict[str, Any]]:
    """Requests overlap, so each is a slice with a beginning and an end of its own."""
    levels = [*labels.caches, "dram"]
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
        ticks = command.clocks * timeline.dram_period_ticks
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


def _held(timeline: Timeline, labels: Labels) -> Iterator[dict[str, Any]]:
    """How full fifos and delay streams are."""
    for tick, channel, held in timeline.held:
        yield {
            "ph": "C",
            "pid": _BETWEEN,
            "ts": tick,
            "name": labels.channels[channel],
            "args": {"held": held},
        }
