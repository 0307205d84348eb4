"""The machine of fixed-function stages, compiled: returns exactly the counters of reference.py, much faster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from archsim.errors import ArchsimError, fail
from archsim.machine.compiled import check_memory, memory_counters, roomy
from archsim.machine.counters import STALL_MEMORY, without_cores
from archsim.machine.flush import drained_cycles, flushed, next_dirty
from archsim.machine.pipeline.checking import channel_ends, checked_records
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.pipeline.loop import NEEDS_ROOM, PAUSED, WORK_WANTED, play
from archsim.machine.pipeline.series import pipeline_sample
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.machine.pipeline.state import WORK, Machine, State
from archsim.machine.pipeline.stuck import Wait, deadlock, unbalanced
from archsim.machine.series import Sampling
from archsim.machine.state import ANSWER, RUN
from archsim.machine.waits import new_waits
from archsim.machine.watch import Levels, Watch
from archsim.machine.watching import Teller
from archsim.model.cache.compiled_state import cache_table, most_fetches, most_sent, new_caches
from archsim.model.causes import num_causes
from archsim.model.compiled import NEVER, integers, new_queues
from archsim.model.core.compiled import new_cores
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.delay_stream.compiled import READS, WRITES, new_streams
from archsim.model.dram.commands import CommandSink
from archsim.model.dram.compiled import new_dram
from archsim.model.fifo.compiled import new_pipes
from archsim.model.pool.compiled import new_pools
from archsim.model.unit.compiled import new_stages
from archsim.trace.records import RECORD, Op, Tasks, joined
from archsim.trace.stream import PipelineWork

Progress = Callable[[int], Any]  # called with the tasks ended


def simulate(
    spec: PipelineSpec,
    work: PipelineWork,
    progress: Progress | None = None,
    sink: CommandSink | None = None,
    watch: Watch | None = None,
    flush: bool = False,
    sampling: Sampling | None = None,
) -> PipelineCounters:
    """Play the work to its end and to the last request's; the DRAM's commands go to `sink`.

    With `flush` all dirty lines are written back at the end. `sampling` is told counts at intervals. Raises
    ArchsimError for work that cannot be played.
    """
    machine = _machine(spec)
    teller = Teller(Levels(len(spec.caches), spec.period_ticks, spec.dram.period_ticks), sink, watch)
    initial = teller.ready(_initial_state(spec, machine, () if watch is None else watch.places))
    state = _with_chunk(spec, work.units, initial, work.chunks)
    if sampling is not None:
        state.run[0]["pause"] = sampling.interval_cycles

    def with_room(state: State) -> State:
        teller.collect(state, is_over=False)
        return _with_room(machine, state)

    unflushed = list(range(len(spec.caches))) if flush else []
    while True:
        status = play(machine, state)
        if status == WORK_WANTED:
            if progress is not None:
                progress(int(state.stages.units["tasks"].sum()))
            state = _with_chunk(spec, work.units, state, work.chunks)
        elif status == NEEDS_ROOM:
            state = with_room(state)
        elif status == PAUSED:
            assert sampling is not None
            cycle = int(state.run[0]["pause"])
            sampling.take(pipeline_sample(cycle, _counters(spec, state, cycle)))
            state.run[0]["pause"] += sampling.interval_cycles
        elif (error := _error(spec, work.units, state)) is not None:
            raise error
        elif (cache := next_dirty(machine, state, unflushed)) is not None:
            state = flushed(machine, state, cache, with_room)
        else:
            break

    teller.collect(state, is_over=True)
    return _counters(spec, state, int(state.stages.units["last_move"].max(initial=0)))


def _machine(spec: PipelineSpec) -> Machine:
    """The spec as the loop wants it. ArchsimError where it makes no sense."""
    producers, consumers = channel_ends(spec)
    check_memory(spec.caches, spec.dram)
    burst_bytes = spec.dram.burst_beats * spec.dram.beat_bytes
    num_requesters = len(spec.units) + len(spec.delay_streams)
    streams = new_streams(spec.delay_streams)
    most = max([1, 2 * streams.under_way.shape[2], *(unit.outstanding for unit in spec.units)])
    return Machine(
        core=CoreSpec(num_requesters, most, int(spec.period_ticks), int(TaskOrder.FIRST_FREE)),
        caches=cache_table(spec.caches, burst_bytes),
        dram=integers(spec.dram),
        burst_shift=burst_bytes.bit_length() - 1,
        spare_slots=num_requesters * most + most_sent(spec.caches),
        answer_clocks=min(
            spec.dram.read_clocks(num_bursts=1), int(spec.dram.timing.n_wl)
        ),  # writes are answered, too
        producers=np.array(producers, np.int64),
        consumers=np.array(consumers, np.int64),
    )


def _initial_state(spec: PipelineSpec, machine: Machine, watched: tuple[int, ...]) -> State:
    """Cycle 0: all channels, caches and queues empty, no task loaded."""
    num_accesses = machine.core.num_cores * machine.core.num_threads
    num_fetches = most_fetches(spec.caches) + num_accesses + 1
    longest_wake = max((cache.hit_cycles for cache in spec.caches), default=1)
    queue_capacity = 64 + 2 * machine.spare_slots

    num_reasons = STALL_MEMORY + num_causes(len(spec.caches))
    core = new_cores(machine.core, num_reasons, longest_wake)
    core.ready[:] = 0
    run = np.zeros(1, RUN)
    run["next_answer"] = run["next_lookup"] = run["pause"] = NEVER
    cache = new_caches(machine.caches, spec.caches, queue_capacity, watched)
    return State(
        stages=new_stages(spec.units, num_reasons),
        pipes=new_pipes(spec.fifos),
        streams=new_streams(spec.delay_streams),
        stream_roused=np.zeros(len(spec.delay_streams), np.int64),
        pools=new_pools(spec.pools),
        records=np.zeros(0, RECORD),
        work=np.zeros(1, WORK),
        core=core,
        cache=cache,
        dram=new_dram(machine.dram, queue_capacity),
        answers=new_queues(2, num_fetches, ANSWER),
        filling=np.zeros(num_fetches, np.int64),
        sources=np.zeros(num_fetches, np.int64),
        waits=new_waits(num_accesses, cache.mshrs, are_threads_at_dram=True),
        run=run,
    )


def _with_chunk(
    spec: PipelineSpec, names: Sequence[str], state: State, chunks: Iterator[tuple[Tasks, ...]]
) -> State:
    """The state with one more chunk and without the records that were played."""
    chunk = next(chunks, None)
    if chunk is None:
        state.work["is_over"] = 1
        return state
    if len(chunk) != len(spec.units):
        raise fail(f"a chunk holds the tasks of {len(chunk)} units; there are {len(spec.units)}")

    units, parts, end = state.stages.units, [], 0
    for number, tasks in enumerate(chunk):
        left = state.records[units[number]["cursor"] : units[number]["end"]]
        parts += [left, checked_records(spec, tuple(names), number, tasks)]
        units[number]["cursor"] = end
        end += len(parts[-2]) + len(parts[-1])
        units[number]["end"] = end
    return state._replace(records=joined(parts))


def _with_room(machine: Machine, state: State) -> State:
    """The state with larger queues, where what a cycle may add no longer fits in."""
    state.run[0]["needs_room"] = 0
    cache = state.cache._replace(inbox=roomy(state.cache.inbox, machine.spare_slots))
    dram = state.dram._replace(queue=roomy(state.dram.queue, machine.spare_slots))
    return state._replace(cache=cache, dram=dram)


def _error(spec: PipelineSpec, names: Sequence[str], state: State) -> ArchsimError | None:
    """What is wrong with the end of the run: a unit with work left, items or tokens that are left over; or nothing."""
    units = state.stages.units
    is_stuck = (units["cursor"] < units["end"]) | (units["oldest"] < units["next"])
    if np.any(is_stuck) or state.work[0]["is_over"] == 0:
        waits = [wait for number in range(len(units)) for wait in _waits(state, number)]
        return deadlock(spec, names, int(state.run[0]["cycle"]), waits)
    put, taken = _items(state)
    held = state.pools.pools["acquired"] - state.pools.released["count"]
    return unbalanced(spec, names, (put - taken).tolist(), held.tolist())


def _waits(state: State, number: int) -> Iterator[Wait]:
    """The operations that the unit cannot do, of its back and of its front."""
    unit, in_flight = state.stages.units[number], state.stages.in_flight[number]
    if unit["oldest"] < unit["next"]:
        oldest = in_flight[unit["oldest"] % len(in_flight)]
        if oldest["op"] == Op.EMIT:
            yield number, Op.EMIT, int(oldest["address"])
    if unit["cursor"] < unit["end"]:
        record = state.records[unit["cursor"]]
        if record["op"] in (Op.TAKE, Op.ACQUIRE):
            yield number, Op(int(record["op"])), int(record["address"])


def _hit_cycles(spec: PipelineSpec) -> np.ndarray:
    return np.array([cache.hit_cycles for cache in spec.caches], np.int64)


def _items(state: State) -> tuple[np.ndarray, np.ndarray]:
    """Items put into and taken from each channel."""
    pipes, streams = state.pipes, state.streams.streams
    put = np.concatenate([pipes.put_in["count"], streams["num_put"]])
    taken = np.concatenate([pipes.taken["count"], streams["num_taken"]])
    return put, taken


def _stayed(state: State) -> np.ndarray:
    """Cycles that items or bytes were in each channel until now, summed over them."""
    pipes, streams = state.pipes, state.streams
    held = np.concatenate(
        [pipes.put_in["count"] - pipes.taken["count"], streams.pushed["count"] - streams.taken["count"]]
    )
    stayed = np.concatenate([pipes.pipes["stayed"], streams.streams["stayed"]])
    return np.asarray(stayed + held * state.run[0]["cycle"])


def _counters(spec: PipelineSpec, state: State, cycles: int) -> PipelineCounters:
    """What the state says of a run that takes so many cycles, or of its beginning."""
    units, streams, pools = state.stages.units, state.streams, state.pools
    put, taken = _items(state)
    slots = state.stages.slots.copy()
    for number, unit in enumerate(units):
        slots[number, unit["slot"]] += cycles - unit["since"]
    return PipelineCounters(
        cycles=cycles,
        unit_slots=slots,
        unit_waits=state.stages.waits[:, STALL_MEMORY:].copy(),
        unit_tasks=units["tasks"].copy(),
        unit_loads=units["loads"].copy(),
        unit_stores=units["stores"].copy(),
        unit_clears=units["clears"].copy(),
        unit_load_bytes=units["load_bytes"].copy(),
        unit_store_bytes=units["store_bytes"].copy(),
        channel_put=put,
        channel_taken=taken,
        channel_peak=np.concatenate([state.pipes.pipes["peak"], streams.streams["peak"]]),
        channel_stayed=_stayed(state),
        stream_bytes=streams.pushed["count"].copy(),
        stream_writes=streams.transfers["next"][:, WRITES].copy(),
        stream_reads=streams.transfers["next"][:, READS].copy(),
        stream_marks=streams.streams["marks"].copy(),
        stream_early=streams.streams["early"].copy(),
        pool_acquired=pools.pools["acquired"].copy(),
        pool_released=pools.released["count"].copy(),
        pool_peak=pools.pools["peak"].copy(),
        memory=without_cores(
            cycles,
            drained_cycles(state.run, spec.period_ticks, spec.dram.period_ticks),
            memory_counters(state, _hit_cycles(spec), spec.period_ticks),
        ),
    )
