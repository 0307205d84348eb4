"""Play work on a machine, by either model."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from archsim.machine.counters import Counters
from archsim.machine.heard import NOTHING, Heard
from archsim.machine.series import sample_of
from archsim.machine.spec import MachineSpec
from archsim.trace.stream import Work

MODELS = ("reference", "compiled")


def play(
    model: str,
    spec: MachineSpec,
    work: Work,
    progress: Callable[[int, int], None] | None = None,
    heard: Heard = NOTHING,
    flush: bool = False,
) -> Counters:
    """Counters of the work on the machine; with `flush` dirty lines are written back at the end.

    Loads only the model asked for: each brings a heavy library.
    """
    if model not in MODELS:
        raise ValueError(f"no model named {model!r}")
    simulate = import_module(f"archsim.machine.{model}").simulate
    counters: Counters = simulate(spec, work, progress, **asked_of(model, heard), flush=flush)
    if heard.sampling is not None:
        heard.sampling.take(sample_of(counters.drained_cycles + 1, counters))
    return counters


def asked_of(model: str, heard: Heard) -> dict[str, Any]:
    """What is to be told, as the model's arguments. Only the reference can be observed."""
    asked = heard._asdict()
    if heard.observe is None:
        del asked["observe"]
    elif model != "reference":
        raise ValueError(f"{model!r} cannot be observed")
    return asked
