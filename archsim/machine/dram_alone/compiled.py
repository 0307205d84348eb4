"""A DRAM fed with a stream, compiled: each channel goes from one clock in which something happens to the next."""

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
    channel_of,
    find_next_due,
    has_room,
    is_empty,
    is_idle,
    is_log_half_full,
    new_dram,
    next_due,
    recording,
    send,
    take_log,
    wake,
)
from archsim.model.dram.spec import DramSpec

RUN = record(
    "clock",  # before which the channel concerned has been played
    "first",  # request of the chunk that enters next
    "latency_sum",
    "latency_max",
    "end",  # last clock in which a request was served or a read answered
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
        clocks=max(int(run[0]["end"]), int(state.channels["data_end"].max())),
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
    """Go on until a chunk is needed, the log is half full, or all has been served.

    What a channel does depends on others only by when its requests enter. So a request's channel alone is played, up
    to the clock in which there is room; all are if commands are recorded, or when no request is left. There is one
    loop, because an inner one of a single channel would prepare for all that can happen to that channel.
    """
    now = run[0]
    number, last = _concerned(spec, state, requests, now)
    while now["first"] < len(requests.addresses) or now["is_last"] != 0:
        if state.due[number] < now["clock"]:
            _wake(spec, state, now, np.uint32(number), latencies)
        elif number < last:
            number += 1
        else:
            if now["first"] < len(requests.addresses):
                _enter(spec, state, requests, bursts, now)
            elif not _go_on(spec, state, now):
                return
            if is_log_half_full(state):
                return
            number, last = _concerned(spec, state, requests, now)


@inlined_step
def _concerned(spec, state, requests, now):
    """The first and the last channel to be played before the next request enters, if any; the first clock for that."""
    if now["first"] < len(requests.addresses):
        now["clock"] = max(now["clock"], requests.arrivals[now["first"]])
        if len(state.log) == 0:
            number = np.int64(channel_of(spec, requests.addresses[now["first"]]))
            return number, number
    return 0, len(state.due) - 1


@inlined_step
def _go_on(spec, state, now):
    """The next clock to play all channels to when no request is left; False if all has been."""
    if not is_empty(spec, state):
        find_next_due(state)
        now["clock"] = next_due(state) + 1
    elif now["clock"] <= now["end"]:
        now["clock"] = now["end"] + 1
    else:
        now["is_over"] = 1
    return now["is_over"] == 0


@inlined_step
def _enter(spec, state, requests, bursts, now):
    """The next request enters in this clock if there is room, or else in a later one."""
    clock, address, is_write = now["clock"], requests.addresses[now["first"]], requests.is_write[now["first"]]
    if not has_room(spec, state, address, is_write):
        now["clock"] = state.due[channel_of(spec, address)] + 1
        return
    request = send(spec, state, clock * spec.period_ticks, address, 0, is_write)
    request["bursts"] = bursts
    request["requester"] = NO_REQUESTER if is_write else ~clock
    now["wait_sum"] += clock - requests.arrivals[now["first"]]
    now["first"] += 1


@inlined_step
def _wake(spec, state, now, number, latencies):
    """Wake a channel that is due."""
    if not is_idle(spec, state, number):
        now["end"] = max(now["end"], state.due[number])
    requester = wake(spec, state, number)
    if requester != NO_REQUESTER:
        answer = answer_cycle(spec, state, number, spec.period_ticks)
        latency = answer - ~requester
        latencies[min(latency, LONGEST_LATENCY)] += 1
        now["latency_sum"] += latency
        now["latency_max"] = max(now["latency_max"], latency)
        now["end"] = max(now["end"], answer)
