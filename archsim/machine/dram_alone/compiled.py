"""A DRAM fed with a stream, compiled: goes from one clock in which something happens to the next."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from archsim.jit import njit
from archsim.machine.dram_alone.stream import LONGEST_LATENCY, DramRun, Requests, bursts_of, check
from archsim.model.compiled import inlined_step, integers, record
from archsim.model.dram.commands import DRAM_COUNTERS, CommandSink
from archsim.model.dram.compiled import (
    NO_REQUESTER,
    DramState,
    answer_cycle,
    first_channel,
    first_clock,
    has_room,
    is_empty,
    is_log_half_full,
    new_dram,
    recording,
    send,
    take_log,
    wake_first,
)
from archsim.model.dram.spec import DramSpec

RUN = record(
    "clock",
    "first",  # request of the chunk that enters next
    "latency_sum",
    "latency_max",
    "last_answer",  # clock in which the last read was answered
    "wait_sum",
    "is_last",  # whether no chunk follows
    "is_over",  # whether all has been served
)


def simulate(
    spec: DramSpec, request_bytes: int, chunks: Iterable[Requests], sink: CommandSink | None = None
) -> DramRun:
    """Serve the stream; the commands go to `sink`. ArchsimError for requests that can't be served."""
    bursts = bursts_of(spec, request_bytes)
    plain = integers(spec)
    state = new_dram(plain, spec.num_queue_entries + spec.num_write_entries)
    if sink is not None:
        state = recording(state)
    run, latencies = np.zeros(1, RUN), np.zeros(LONGEST_LATENCY + 1, np.int64)
    previous_arrival = 0
    for requests in chunks:
        check(requests, previous_arrival)
        _play(plain, state, _plain_requests(requests), bursts, run, latencies, sink)
        previous_arrival = int(requests.arrivals[-1]) if len(requests.arrivals) else previous_arrival
    run[0]["is_last"] = 1
    nothing = Requests(*(np.zeros(0, np.int64) for _ in Requests._fields))
    _play(plain, state, _plain_requests(nothing), bursts, run, latencies, sink)
    return DramRun(
        clocks=max(int(run[0]["last_answer"]), int(state.channels["data_end"].max())),
        counters={name: state.channels[name].copy() for name in DRAM_COUNTERS},
        latencies=latencies,
        latency_sum=int(run[0]["latency_sum"]),
        latency_max=int(run[0]["latency_max"]),
        wait_sum=int(run[0]["wait_sum"]),
    )


def _plain_requests(requests: Requests) -> Requests:
    """The same with the types that the loop is compiled for."""
    types = (np.int64, np.bool_, np.int64)
    return Requests(*(np.ascontiguousarray(each, kind) for each, kind in zip(requests, types, strict=True)))


def _play(
    spec: DramSpec,
    state: DramState,
    requests: Requests,
    bursts: int,
    run: np.ndarray,
    latencies: np.ndarray,
    sink: CommandSink | None,
) -> None:
    """Let all requests of a chunk enter."""
    run[0]["first"] = 0
    while True:
        _advance(spec, state, requests, bursts, run, latencies)
        if sink is not None:
            take_log(state, sink)
        if run[0]["is_over"] or (run[0]["first"] == len(requests.addresses) and not run[0]["is_last"]):
            return


@njit(error_model="numpy", _nrt=False, no_cfunc_wrapper=True)
def _advance(spec, state, requests, bursts, run, latencies):
    """Go on until a chunk is needed, the log is full, or all has been served."""
    now = run[0]
    while True:
        _enter(spec, state, requests, bursts, now)
        if now["first"] == len(requests.addresses) and now["is_last"] == 0:
            return
        while first_clock(state) <= now["clock"]:
            _wake(spec, state, now, latencies)
        is_served = now["first"] == len(requests.addresses) and is_empty(state)
        if is_served and now["clock"] >= now["last_answer"]:
            now["is_over"] = 1
            return
        due = _next_clock(spec, state, requests, now)
        now["clock"] = min(due, now["last_answer"]) if is_served else due
        if is_log_half_full(state):
            return


@inlined_step
def _enter(spec, state, requests, bursts, now):
    """The requests that may enter in this clock."""
    first, clock = now["first"], now["clock"]
    while first < len(requests.addresses) and requests.arrivals[first] <= clock:
        address, is_write = requests.addresses[first], requests.is_write[first]
        if not has_room(spec, state, address, is_write):
            break
        request = send(spec, state, clock * spec.period_ticks, address, 0, is_write)
        request["bursts"] = bursts
        request["requester"] = NO_REQUESTER if is_write else ~clock
        now["wait_sum"] += clock - requests.arrivals[first]
        first += 1
    now["first"] = first


@inlined_step
def _wake(spec, state, now, latencies):
    """Wake the channel that is due."""
    number = first_channel(state)
    requester = wake_first(spec, state)
    if requester != NO_REQUESTER:
        answer = answer_cycle(spec, state, number, spec.period_ticks)
        latency = answer - ~requester
        latencies[min(latency, LONGEST_LATENCY)] += 1
        now["latency_sum"] += latency
        now["latency_max"] = max(now["latency_max"], latency)
        now["last_answer"] = max(now["last_answer"], answer)


@inlined_step
def _next_clock(spec, state, requests, now):
    """The next clock in which a channel is due or a request may enter."""
    clock, first, due = now["clock"], now["first"], first_clock(state)
    if first < len(requests.addresses):
        if requests.arrivals[first] > clock:
            due = min(due, requests.arrivals[first])
        elif has_room(spec, state, requests.addresses[first], requests.is_write[first]):
            due = clock + 1
    return max(due, clock + 1)
