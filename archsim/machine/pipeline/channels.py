"""What units do to channels and pools, in the compiled pipeline: the change, and who is roused by it."""

from __future__ import annotations

from archsim.machine.pipeline.accesses import number_of
from archsim.machine.pipeline.state import Machine, State
from archsim.model.compiled import inlined_step, step
from archsim.model.delay_stream import compiled as stream_model
from archsim.model.delay_stream.compiled import NO_TRANSFER
from archsim.model.fifo import compiled as fifo_model
from archsim.model.pool import compiled as pool_model
from archsim.model.unit import compiled as unit_model
from archsim.model.unit.compiled import NO_ACCESS


@inlined_step
def is_stream(state: State, channel):
    """Whether the channel is a delay stream."""
    return channel >= len(state.pipes.pipes)


@inlined_step
def has_item(state: State, cycle, channel):
    """Whether an item can be taken from the channel in `cycle`."""
    num_pipes = len(state.pipes.pipes)
    if channel < num_pipes:
        return fifo_model.has_item(state.pipes, cycle, channel)
    return stream_model.has_item(state.streams, cycle, channel - num_pipes)


@inlined_step
def coming(spec: Machine, state: State, cycle, channel):
    """The access of a delay stream, among all, that in `cycle` is on its way with what is to be taken, or NO_ACCESS."""
    num_pipes = len(state.pipes.pipes)
    if channel < num_pipes:
        return NO_ACCESS
    transfer = stream_model.coming(state.streams, cycle, channel - num_pipes)
    if transfer == NO_TRANSFER:
        return NO_ACCESS
    return number_of(spec, len(state.stages.units) + channel - num_pipes, transfer)


@inlined_step
def take(spec: Machine, state: State, cycle, channel):
    """The oldest item leaves the channel in `cycle`; from the next one on there is room."""
    num_pipes = len(state.pipes.pipes)
    if channel < num_pipes:
        fifo_model.take(state.pipes, cycle, channel)
    else:
        stream_model.take(state.streams, cycle, channel - num_pipes)
        rouse_stream(state, cycle + 1, channel - num_pipes)
    unit_model.rouse(state.stages, cycle + 1, spec.producers[channel])


@inlined_step
def put(spec: Machine, state: State, cycle, channel, num_bytes):
    """Whether an item has room in the channel in `cycle`; then it is put in."""
    num_pipes = len(state.pipes.pipes)
    if channel < num_pipes:
        is_put = fifo_model.put(state.pipes, cycle, channel)
        unit_model.rouse(state.stages, cycle + 1, spec.consumers[channel])
        return is_put
    stream = channel - num_pipes
    is_put = stream_model.put(state.streams, cycle, stream, num_bytes)
    rouse_stream(state, cycle + 1, stream)
    if state.streams.released[stream]["changed"] == cycle:
        unit_model.rouse(state.stages, cycle + 1, spec.consumers[channel])
    return is_put


@inlined_step
def mark(spec: Machine, state: State, cycle, channel):
    """What is in the delay stream may pass from the cycle after `cycle` on."""
    stream = channel - len(state.pipes.pipes)
    stream_model.mark(state.streams, cycle, stream)
    rouse_stream(state, cycle + 1, stream)
    unit_model.rouse(state.stages, cycle + 1, spec.consumers[channel])


@inlined_step
def rouse_stream(state: State, cycle, stream):
    """The delay stream looks again in `cycle`, the next one."""
    state.stream_roused[stream] = cycle


@step
def release(state: State, cycle, pool):
    """A token comes back in `cycle`; it is there for others from the next one on."""
    pool_model.release(state.pools, cycle, pool)
    for number in range(len(state.stages.units)):
        if state.stages.units[number]["num_pools"] > 0:
            unit_model.rouse(state.stages, cycle + 1, number)
