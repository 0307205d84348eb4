"""Replay an address trace on a machine's DRAM alone."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import NamedTuple

import numpy as np

from archsim.config import MachineConfig
from archsim.config.components import CacheConfig
from archsim.config.dram import DramConfig, IdealDramConfig
from archsim.errors import did_you_mean, fail
from archsim.machine.build import dram_spec
from archsim.machine.dram_alone.stream import DramRun, Requests
from archsim.model.dram.commands import CommandSink
from archsim.model.dram.spec import DramSpec
from archsim.run.measure import measured
from archsim.run.replay import Bucket, Census, Replay, replay_of
from archsim.run.replay_statistics import TRACE, DramAloneView, dram_alone
from archsim.run.result import Check
from archsim.trace.access_work import split
from archsim.trace.accesses import Accesses, Kind

_WANTED = (  # statistics for the summary
    "cycles",
    "requests",
    "row_hits",
    "row_misses",
    "row_conflicts",
    "average_read_clocks",
    "median_read_clocks",
    "p99_read_clocks",
    "gigabytes_per_second",
    "peak_percent",
)


_IDEAL_REQUEST_BYTES = 64  # of an ideal DRAM, which has no bursts, without caches above it


class DramPart(NamedTuple):
    """A DRAM of a machine, ready to be asked."""

    spec: DramSpec
    request_bytes: int
    hertz: int  # of the memory clock
    capacity_bytes: int


def dram_part(machine: MachineConfig, name: str | None) -> DramPart:
    """The DRAM of that name, the only one without a name. ArchsimError if there is none such.

    A request is a line of the caches above it; without caches, a burst.
    """
    drams: dict[str, DramConfig | IdealDramConfig] = {
        **machine.all_of(DramConfig),
        **machine.all_of(IdealDramConfig),
    }
    if name is None and len(drams) == 1:
        name = next(iter(drams))
    if name is None or name not in drams:
        there_are = f"there are: {', '.join(drams)}" if drams else "there is none"
        raise fail(
            f"which DRAM? The machine has no '{name or 'dram'}'",
            hint=did_you_mean(name or "", drams) or there_are,
        )

    config = drams[name]
    lines = [cache.line for cache in machine.all_of(CacheConfig).values() if cache.next == name]
    burst_bytes = config.burst_bytes if isinstance(config, DramConfig) else _IDEAL_REQUEST_BYTES
    request_bytes = lines[0] if lines else burst_bytes
    spec = dram_spec(config, request_bytes, 1)
    return DramPart(spec, request_bytes, machine.clocks[config.clock], config.capacity_bytes)


def replay_on_dram(
    name: str, accesses: Accesses, part: DramPart, model: str, sink: CommandSink | None = None
) -> Replay:
    """Every request enters at its cycle, a memory clock, or as soon as its channel's queue has room, in order.

    The DRAM's commands go to `sink`.
    """
    census, made = Census(), [0]

    def requests() -> Iterator[Requests]:
        for chunk in census.watch(accesses):
            pieces = split(chunk, part.request_bytes)
            made[0] += len(pieces)
            yield _requests(pieces, part)

    run: DramRun = import_module(f"archsim.machine.dram_alone.{model}").simulate(
        part.spec, part.request_bytes, requests(), sink
    )
    statistics = measured("trace", TRACE, census.kinds)
    statistics += dram_alone(DramAloneView(run, part.spec), part.hertz)
    check = Check(
        "requests served = requests made", run.num_requests == made[0], f"{run.num_requests} = {made[0]}"
    )
    wanted = ["trace.accesses", *(f"dram.{name}" for name in _WANTED)]
    return replay_of(name, statistics, [check], wanted, _buckets(run))


def _requests(pieces: np.ndarray, part: DramPart) -> Requests:
    """Requests for pieces that lie in one each; addresses beyond the end of the memory begin again at 0."""
    addresses = pieces["address"] // part.request_bytes * part.request_bytes % part.capacity_bytes
    return Requests(addresses, pieces["kind"] == Kind.WRITE, np.ascontiguousarray(pieces["cycle"]))


def _buckets(run: DramRun) -> list[Bucket]:
    """Reads by latency, in classes whose bounds are powers of two."""
    found, least = [], 1
    while least <= run.latency_max:
        most = 2 * least - 1
        last = len(run.latencies) - 1  # the class of all that are longer
        reads = int(run.latencies[least:].sum() if most >= last else run.latencies[least : most + 1].sum())
        found.append(Bucket(least, run.latency_max if most >= last else most, reads))
        if most >= last:
            break
        least *= 2
    return [bucket for bucket in found if bucket.reads > 0]
