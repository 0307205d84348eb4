"""The machine of fixed-function stages, to be believed: builds the components' SimPy models, runs them, reads them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from typing import Any

import numpy as np
import simpy

from archsim.errors import fail
from archsim.machine.counters import without_cores
from archsim.machine.pipeline.checking import channel_ends, checked_records
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.pipeline.series import pipeline_sample
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.machine.pipeline.stuck import deadlock, unbalanced
from archsim.machine.reference import Tap, constantly, is_drained, make_caches, memory_counters, telling
from archsim.machine.series import Sampling
from archsim.machine.watch import SEEN, Levels, Watch, in_order, tell
from archsim.model.cache.reference import Answer, Kind, Request
from archsim.model.cache.spec import DRAM_PARENT
from archsim.model.causes import num_causes
from archsim.model.delay_stream.reference import DelayStream
from archsim.model.dram.commands import COMMAND, CommandSink
from archsim.model.dram.reference import Dram
from archsim.model.fifo.reference import Pipe
from archsim.model.pool.reference import Pool
from archsim.model.reference import Phase, at, call
from archsim.model.unit.reference import Channel, Send, Stage
from archsim.model.unit.spec import NO_MEMORY, Slot
from archsim.model.waiting import Wait
from archsim.trace.stream import PipelineWork

Progress = Callable[[int], None]  # (tasks ended)


def simulate(
    spec: PipelineSpec,
    work: PipelineWork,
    progress: Progress | None = None,
    sink: CommandSink | None = None,
    observe: Callable[[Machine], None] | None = None,
    watch: Watch | None = None,
    flush: bool = False,
    sampling: Sampling | None = None,
) -> PipelineCounters:
    """Play `work` on the machine `spec` and return its counters. The whole work is held in memory.

    The DRAM's commands go to `sink`; `observe` is shown the machine before anything happens. With `flush` all dirty
    lines are written back at the end. `sampling` is told counts at intervals.
    Raises ArchsimError for work that the machine cannot do, DeadlockError when it gets stuck.
    """
    channel_ends(spec)
    machine = Machine(spec, work.units, _all_records(spec, work))
    commands: list[tuple[int, ...]] = []
    if sink is not None:
        machine.dram.record(commands)
    if sampling is not None:
        machine.env.process(telling(machine, sampling, spec.period_ticks, pipeline_sample))
    if observe is not None:
        observe(machine)
    seen = machine.tap(watch.places) if watch is not None else []
    if not all(unit.is_done() for unit in machine.units):
        machine.env.run(until=machine.env.process(machine.watch(progress, flush)))
    if sink is not None:
        sink(np.array(commands, COMMAND))
    if watch is not None:
        levels = Levels(len(spec.caches), spec.period_ticks, spec.dram.period_ticks)
        tell(levels, watch, in_order(np.array(seen, SEEN)))
    counters = machine.counters()
    left, held = (
        counters.channel_put - counters.channel_taken,
        counters.pool_acquired - counters.pool_released,
    )
    error = unbalanced(spec, work.units, left.tolist(), held.tolist())
    if error is not None and machine.is_over:
        raise error
    return counters


def _all_records(spec: PipelineSpec, work: PipelineWork) -> list[list[Any]]:
    """The records of every unit, checked."""
    records: list[list[Any]] = [[] for _ in spec.units]
    for chunk in work.chunks:
        if len(chunk) != len(spec.units):
            raise fail(f"a chunk holds the tasks of {len(chunk)} units; there are {len(spec.units)}")
        for unit, tasks in enumerate(chunk):
            records[unit].extend(checked_records(spec, work.units, unit, tasks))
    return records


class Machine:
    """The components of one pipeline, wired. Units send before delay streams, these before caches."""

    def __init__(self, spec: PipelineSpec, names: tuple[str, ...], records: list[list[Any]]):
        self.spec, self.names = spec, names
        self.env = env = simpy.Environment()
        self.is_over = False  # not if an observer ended it
        self.drained_cycle = 0  # when it was over
        self.dram = Dram(spec.dram, env, len(spec.caches), spec.period_ticks)
        num_units, num_streams = len(spec.units), len(spec.delay_streams)
        self.caches = make_caches(spec.caches, env, num_units + num_streams, spec.period_ticks, self.dram)
        self.targets: list[Any] = [*self.caches, self.dram]  # whom units and delay streams ask
        self.pools = [Pool(pool) for pool in spec.pools]
        self.fifos = [Pipe(fifo) for fifo in spec.fifos]
        self.streams = [
            DelayStream(
                stream, env, num_units + k, spec.period_ticks, self._sender(num_units + k, DRAM_PARENT)
            )
            for k, stream in enumerate(spec.delay_streams)
        ]
        self.units = [self._make_unit(index, iter(records[index])) for index in range(num_units)]
        components: list[Any] = [*self.units, *self.streams, *self.caches, *self.dram.channels]
        for component in components:
            env.process(component.run())

    def _make_unit(self, index: int, records: Iterator[Any]) -> Stage:
        stage = self.spec.units[index]
        channels: list[Channel] = [*self.fifos, *self.streams]
        send = self._sender(index, stage.memory)
        return Stage(stage, self.env, index, self.spec.period_ticks, records, channels, self.pools, send)

    def _sender(self, sender: int, memory: int) -> Send:
        """How the component asks its cache or the DRAM: the request is there in the same tick."""

        def send(now: int, kind: Kind, address: int, num_bytes: int, answer: Answer, wait: Wait) -> None:
            assert memory != NO_MEMORY
            request = Request(kind, address, num_bytes, answer, wait, sender)
            if memory == DRAM_PARENT:
                request = self._whole_bursts(request)
            call(at(self.env, now, Phase.ARRIVE, sender), self.targets[memory].arrive, request)

        return send

    def _whole_bursts(self, request: Request) -> Request:
        """The request with all bytes of the bursts that it touches."""
        burst_bytes = self.spec.dram.burst_beats * self.spec.dram.beat_bytes
        first = request.address // burst_bytes
        last = (request.address + request.num_bytes - 1) // burst_bytes
        return request._replace(address=first * burst_bytes, num_bytes=(last - first + 1) * burst_bytes)

    def tap(self, places: tuple[int, ...]) -> list[Any]:
        """Note all requests to these caches (or, by the number of caches, the DRAM) in the list that is returned."""
        targets = [[*self.caches, self.dram][place] for place in places]
        seen: list[Any] = []

        def cycle() -> int:
            return int(self.env.now) // self.spec.period_ticks

        for cache in self.caches:
            if cache.parent in targets:
                cache.parent = Tap(cache.parent, constantly(cache.index), seen, cycle)
        self.targets = [
            Tap(target, _sender_of, seen, cycle) if target in targets else target for target in self.targets
        ]
        return seen

    def watch(self, progress: Progress | None, flush: bool) -> Generator[simpy.Event, None, None]:
        """The process that ends the run: after the first tick with all done and nothing on its way."""
        tick, periods = 0, (self.spec.period_ticks, self.spec.dram.period_ticks)
        unflushed = iter(self.caches if flush else [])
        while True:
            yield at(self.env, tick, Phase.END)
            if progress is not None:
                progress(sum(unit.counts["tasks"] for unit in self.units))
            is_quiet = self.dram.is_quiet() and all(cache.is_quiet() for cache in self.caches)
            is_done = all(unit.is_done() for unit in self.units)
            if is_quiet and is_done and is_drained(self, tick, unflushed):
                self.is_over = True
                self.drained_cycle = -(-tick // self.spec.period_ticks)
                return
            if is_quiet and not is_done and tick % self.spec.period_ticks == 0:
                self._check_deadlock(tick)
            tick = min((tick // period + 1) * period for period in periods)

    def _check_deadlock(self, now: int) -> None:
        """Stuck: no access is under way, and whoever has something left to do waits for another."""
        components: list[Any] = [*self.units, *self.streams]
        if all(component.is_stuck(now) for component in components):
            waits = [(number, *wait) for number, unit in enumerate(self.units) for wait in unit.waits()]
            raise deadlock(self.spec, self.names, now // self.spec.period_ticks, waits)

    def counters(self) -> PipelineCounters:
        cycles = max((unit.last_move for unit in self.units), default=0) // self.spec.period_ticks
        units, fifos, streams, pools = self.units, self.fifos, self.streams, self.pools
        stays = [channel.stays for channel in fifos] + [channel.stays for channel in streams]
        return PipelineCounters(
            cycles=cycles,
            unit_slots=np.array([_slots(unit, cycles) for unit in units], np.int64).reshape(-1, len(Slot)),
            unit_waits=np.array(
                [[unit.waited[cause] for cause in range(num_causes(len(self.caches)))] for unit in units],
                np.int64,
            ).reshape(len(units), -1),
            unit_tasks=_array(unit.counts["tasks"] for unit in units),
            unit_loads=_array(unit.counts["loads"] for unit in units),
            unit_stores=_array(unit.counts["stores"] for unit in units),
            unit_clears=_array(unit.counts["clears"] for unit in units),
            unit_load_bytes=_array(unit.counts["loads_bytes"] for unit in units),
            unit_store_bytes=_array(unit.counts["stores_bytes"] for unit in units),
            channel_put=_array([*(f.put_in.count for f in fifos), *(s.num_put for s in streams)]),
            channel_taken=_array([*(f.taken.count for f in fifos), *(s.num_taken for s in streams)]),
            channel_peak=_array([*(f.peak_items for f in fifos), *(s.peak_bytes for s in streams)]),
            channel_stayed=_array(stay.ticks(int(self.env.now)) // self.spec.period_ticks for stay in stays),
            stream_bytes=_array(stream.pushed.count for stream in streams),
            stream_writes=_array(stream.num_writes for stream in streams),
            stream_reads=_array(stream.num_reads for stream in streams),
            stream_marks=_array(stream.marks for stream in streams),
            stream_early=_array(stream.early for stream in streams),
            pool_acquired=_array(pool.acquired for pool in pools),
            pool_released=_array(pool.released.count for pool in pools),
            pool_peak=_array(pool.peak for pool in pools),
            memory=without_cores(cycles, self.drained_cycle, memory_counters(self.caches, self.dram)),
        )


def _sender_of(request: Request) -> int:
    return request.sender


def _slots(unit: Stage, cycles: int) -> list[int]:
    """The front's cycles by what it did in them; while the memory drained there was no work."""
    drained = sum(unit.slots.values()) - cycles
    return [unit.slots[slot] - (drained if slot is Slot.NO_WORK else 0) for slot in Slot]


def _array(values: Iterable[int]) -> np.ndarray:
    return np.array(list(values), np.int64)
