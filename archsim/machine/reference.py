"""The whole machine, to be believed: builds the components' SimPy models, runs them, reads their counters."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from typing import Any, cast

import numpy as np
import simpy

from archsim.errors import DeadlockError, Problem, fail
from archsim.machine.checking import check_tasks
from archsim.machine.counters import Counters
from archsim.machine.series import Sample, Sampling, sample_of
from archsim.machine.spec import MachineSpec
from archsim.machine.watch import SEEN, Levels, Watch, in_order, tell
from archsim.model.cache.reference import CACHE_COUNTS, Cache, Kind, Request
from archsim.model.cache.spec import DRAM_PARENT, CacheSpec
from archsim.model.causes import num_causes
from archsim.model.core.reference import LOCK, NO_WORK, Core, State, Thread
from archsim.model.core.spec import TaskOrder
from archsim.model.dram.commands import COMMAND, DRAM_COUNTERS, CommandSink
from archsim.model.dram.reference import Dram
from archsim.model.fifo.reference import Fifo
from archsim.model.latency import NUM_CLASSES
from archsim.model.locks.reference import Locks
from archsim.model.reference import Phase, at
from archsim.model.unit.reference import Source
from archsim.trace.records import RECORD
from archsim.trace.stream import Work

Progress = Callable[[int, int], None]  # (tasks finished, tasks in all)


def simulate(
    spec: MachineSpec,
    work: Work,
    progress: Progress | None = None,
    sink: CommandSink | None = None,
    observe: Callable[[Machine], None] | None = None,
    watch: Watch | None = None,
    flush: bool = False,
    sampling: Sampling | None = None,
) -> Counters:
    """Play `work` on the machine `spec` and return its counters. The whole work is held in memory.

    The DRAM's commands go to `sink`; `observe` is shown the machine before anything happens. With `flush` all dirty
    lines are written back at the end.
    Raises ArchsimError for work that the machine cannot do, DeadlockError when it gets stuck.
    """
    machine = Machine(spec, _all_tasks(spec, work))
    commands: list[tuple[int, ...]] = []
    if sink is not None:
        machine.dram.record(commands)
    if sampling is not None:
        machine.env.process(telling(machine, sampling, spec.core.period_ticks, sample_of))
    if observe is not None:
        observe(machine)
    seen = machine.tap(watch.places) if watch is not None else []
    if work.num_tasks > 0:
        machine.env.run(until=machine.env.process(machine.watch(progress, flush)))
    if sink is not None:
        sink(np.array(commands, COMMAND))
    if watch is not None:
        levels = Levels(len(spec.caches), spec.core.period_ticks, spec.dram.period_ticks)
        tell(levels, watch, in_order(np.array(seen, SEEN)))
    return machine.counters()


def _all_tasks(spec: MachineSpec, work: Work) -> list[Any]:
    """The records of every task, checked."""
    tasks = []
    for chunk in work.chunks:
        records = np.require(chunk.records[chunk.starts[0] : chunk.starts[-1]], RECORD, ["C"])
        check_tasks(spec, chunk.starts - chunk.starts[0], records)
        tasks += [chunk.records[chunk.starts[i] : chunk.starts[i + 1]] for i in range(chunk.num_tasks)]
    if len(tasks) != work.num_tasks:
        raise fail(f"the work holds {len(tasks)} tasks, {work.num_tasks} were announced")
    return tasks


class Tap:
    """Stands before a cache or the DRAM and notes what is asked of it, and who asks."""

    def __init__(
        self, target: Any, sender: Callable[[Request], int], seen: list[Any], cycle: Callable[[], int]
    ):
        self.target, self.sender, self.seen, self.cycle = target, sender, seen, cycle

    def arrive(self, request: Request) -> None:
        """`request` is here now."""
        if request.kind is not Kind.CLEAR:
            sender, is_write = self.sender(request), request.kind is not Kind.READ
            self.seen.append((self.cycle(), request.address, request.num_bytes, sender, is_write))
        self.target.arrive(request)

    def cut(self, address: int, num_bytes: int) -> list[tuple[int, int]]:
        """As what it stands before cuts requests."""
        parts: list[tuple[int, int]] = self.target.cut(address, num_bytes)
        return parts


def constantly(number: int) -> Callable[[Request], int]:
    """The sender of all requests of one cache."""
    return lambda request: number


def _thread(request: Request) -> int:
    """The thread that the answer to a core's request wakes."""
    return int(cast(Any, request.answer).__self__.number)


class Machine:
    """The components of one machine, wired."""

    def __init__(self, spec: MachineSpec, tasks: list[Any]):
        self.spec, self.num_tasks = spec, len(tasks)
        self.drained_cycle = 0  # when the run was over
        self.env = simpy.Environment()
        self.locks = Locks(spec.locks)
        self.dram = Dram(spec.dram, self.env, len(spec.caches), spec.core.period_ticks)
        self.caches = make_caches(
            spec.caches, self.env, spec.core.num_cores, spec.core.period_ticks, self.dram
        )
        self.source: Source | None = None
        take = self._make_take(tasks)
        self.cores = [
            Core(spec.core, self.env, index, self.caches[spec.core_cache[index]], self.locks, take)
            for index in range(spec.core.num_cores)
        ]
        for process in self._processes():
            self.env.process(process)

    def _processes(self) -> list[Generator[simpy.Event, None, None]]:
        sources = [] if self.source is None else [self.source]
        components: list[Any] = [*sources, *self.cores, *self.caches, *self.dram.channels]
        return [component.run() for component in components]

    def _make_take(self, tasks: list[Any]) -> Callable[[Thread], Any]:
        """How a thread gets its next task, None when it idles or retires instead."""
        core, source = self.spec.core, self.spec.source
        if core.task_order == TaskOrder.FIRST_FREE and source.interval_cycles > 0:
            self.source = Source(source, self.env, core.period_ticks, tasks, Fifo(self.spec.fifo))
            return self.source.take

        stream = iter(tasks)
        num_threads = core.num_cores * core.num_threads
        own = [iter(tasks[number::num_threads]) for number in range(num_threads)]

        def take(thread: Thread) -> Any:
            mine = stream if core.task_order == TaskOrder.FIRST_FREE else own[thread.number]
            task = next(mine, None)
            if task is None:
                thread.retire()
            return task

        return take

    def tap(self, places: tuple[int, ...]) -> list[Any]:
        """Note all requests to these caches (or, by the number of caches, the DRAM) in the list that is returned."""
        targets = [[*self.caches, self.dram][place] for place in places]
        seen: list[Any] = []

        def cycle() -> int:
            return int(self.env.now) // self.spec.core.period_ticks

        for core in self.cores:
            if core.cache in targets:
                core.cache = cast(Cache, Tap(core.cache, _thread, seen, cycle))
        for cache in self.caches:
            if cache.parent in targets:
                cache.parent = Tap(cache.parent, constantly(cache.index), seen, cycle)
        return seen

    def watch(self, progress: Progress | None, flush: bool) -> Generator[simpy.Event, None, None]:
        """The process that ends the run: after the first tick with all finished and nothing on its way."""
        tick, periods = 0, (self.spec.core.period_ticks, self.spec.dram.period_ticks)
        unflushed = iter(self.caches if flush else [])
        while True:
            yield at(self.env, tick, Phase.END)
            finished = sum(core.tasks for core in self.cores)
            if progress is not None:
                progress(finished, self.num_tasks)
            if finished < self.num_tasks:
                self._check_deadlock()
            elif is_drained(self, tick, unflushed):
                self.drained_cycle = -(-tick // self.spec.core.period_ticks)
                return
            tick = min((tick // period + 1) * period for period in periods)

    def _check_deadlock(self) -> None:
        """Stuck: no thread is ready, none will get data, none will be handed a task."""
        states = {thread.state for core in self.cores for thread in core.threads}
        if states <= {State.WAITING_LOCK, State.IDLE, State.RETIRED}:
            if self.source is not None and self.source.can_make():
                return
            waits = [
                f"{thread} waits for lock {number}, held by {holder}"
                for thread, number, holder in self.locks.waiting()
            ]
            raise DeadlockError([Problem(None, f"deadlock at tick {self.env.now}: {wait}") for wait in waits])

    def counters(self) -> Counters:
        cycles = max(core.last_finish_tick for core in self.cores) // self.spec.core.period_ticks
        return Counters(
            cycles=cycles,
            useful=_array(core.useful for core in self.cores),
            stalled=np.array([self._stalled(core, cycles) for core in self.cores], np.int64),
            tasks=_array(core.tasks for core in self.cores),
            emitted=_array(core.emitted for core in self.cores),
            locks_taken=self.locks.taken,
            locks_waited=self.locks.waited,
            lock_wait_ticks=self.locks.wait_ticks,
            drained_cycles=self.drained_cycle,
            **memory_counters(self.caches, self.dram),
        )

    def _stalled(self, core: Core, cycles: int) -> list[int]:
        """Empty slots by cause; those after the last issue had no work."""
        after_last = cycles - (core.last_issue_tick // self.spec.core.period_ticks + 1)
        causes = range(num_causes(len(self.caches)))
        return [core.stalled[NO_WORK] + after_last, core.stalled[LOCK], *(core.stalled[i] for i in causes)]


def telling(
    machine: Any, sampling: Sampling, period_ticks: int, sample: Callable[[int, Any], Sample]
) -> Generator[simpy.Event, None, None]:
    """The process that tells what counters say at the beginning of every interval but the first."""
    for cycle in itertools.count(sampling.interval_cycles, sampling.interval_cycles):
        yield at(machine.env, cycle * period_ticks, Phase.SAMPLE)
        sampling.take(sample(cycle, machine.counters()))


def make_caches(
    specs: Sequence[CacheSpec], env: simpy.Environment, first_sender: int, period_ticks: int, dram: Dram
) -> list[Cache]:
    """The caches over a DRAM; cache k sends behind `first_sender + k` others. Parents are made before children."""
    caches: dict[int, Cache] = {}
    for index in reversed(range(len(specs))):
        parent = dram if specs[index].parent == DRAM_PARENT else caches[specs[index].parent]
        caches[index] = Cache(specs[index], env, index, first_sender + index, period_ticks, parent)
    return [caches[index] for index in range(len(specs))]


def is_drained(machine: Any, now: int, unflushed: Iterator[Cache]) -> bool:
    """Whether nothing is on its way below a machine; then the next cache that has something to write back does so."""
    while machine.dram.is_quiet() and all(cache.is_quiet() for cache in machine.caches):
        cache = next(unflushed, None)
        if cache is None:
            return True
        cache.flush(-(-now // cache.period_ticks) * cache.period_ticks)
    return False


def memory_counters(caches: list[Cache], dram: Dram) -> dict[str, np.ndarray]:
    """The counters of caches and DRAM by name."""
    return {
        "cache_reads": _array(cache.accepted[Kind.READ] for cache in caches),
        "cache_writes": _array(cache.accepted[Kind.WRITE] for cache in caches),
        "cache_writebacks_in": _array(cache.accepted[Kind.WRITEBACK] for cache in caches),
        "cache_clears": _array(cache.accepted[Kind.CLEAR] for cache in caches),
        "latencies": np.array([_by_class(level.latencies) for level in caches] + [_by_class(dram.latencies)]),
        **{f"cache_{name}": _array(getattr(cache, name) for cache in caches) for name in CACHE_COUNTS},
        **{
            f"dram_{name}": _array(channel.counts[name] for channel in dram.channels)
            for name in DRAM_COUNTERS
        },
    }


def _array(values: Iterable[int]) -> np.ndarray:
    return np.array(list(values), np.int64)


def _by_class(latencies: Counter[int]) -> np.ndarray:
    return _array(latencies[number] for number in range(NUM_CLASSES))
