"""What to say about a pipeline that cannot go on, or whose work does not add up; the same words for both models."""

from __future__ import annotations

from collections.abc import Sequence

from archsim.errors import ArchsimError, DeadlockError, Problem, fail
from archsim.machine.pipeline.checking import channel_ends
from archsim.machine.pipeline.spec import PipelineSpec
from archsim.trace.records import Op

Wait = tuple[int, Op, int]  # unit, operation that it cannot do, address


def deadlock(spec: PipelineSpec, units: Sequence[str], cycle: int, waits: Sequence[Wait]) -> DeadlockError:
    """What every unit waits for, and who could provide it."""
    what = [
        f"{units[unit]} waits for {_wanted(spec, units, unit, op, address)}" for unit, op, address in waits
    ]
    return DeadlockError(
        [Problem(None, f"deadlock in cycle {cycle}"), *[Problem(None, line) for line in what]]
    )


def _wanted(spec: PipelineSpec, units: Sequence[str], unit: int, op: Op, address: int) -> str:
    producers, consumers = channel_ends(spec)
    stage = spec.units[unit]
    if op == Op.TAKE:
        channel = stage.inputs[address]
        return f"an item from {units[producers[channel]]}{_through(spec, channel)}"
    if op == Op.EMIT:
        channel = stage.outputs[address]
        return f"room for an item to {units[consumers[channel]]}{_through(spec, channel)}"
    pool = stage.pools[address]
    users = [name for name, other in zip(units, spec.units, strict=True) if pool in other.pools]
    return f"a token of the pool of {', '.join(users)}"


def _through(spec: PipelineSpec, channel: int) -> str:
    return " through a delay stream" if channel >= len(spec.fifos) else ""


def unbalanced(
    spec: PipelineSpec, units: Sequence[str], left: Sequence[int], held: Sequence[int]
) -> ArchsimError | None:
    """The error of work that ended with items that nobody took, or tokens that nobody gave back; None if it did not."""
    producers, consumers = channel_ends(spec)
    what = [
        f"{count} items from {units[producers[channel]]} to {units[consumers[channel]]} were never taken"
        for channel, count in enumerate(left)
        if count
    ]
    what += [f"{count} tokens of pool {pool} were never released" for pool, count in enumerate(held) if count]
    return fail(f"the work ended, but {', '.join(what)}") if what else None
