"""Play work on a machine, by either model."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from archsim.machine.counters import Counters
from archsim.machine.spec import MachineSpec
from archsim.machine.watch import Watch
from archsim.model.dram.commands import CommandSink
from archsim.trace.stream import Work

MODELS = ("reference", "compiled")


def play(
    model: str,
    spec: MachineSpec,
    work: Work,
    progress: Callable[[int, int], None] | None = None,
    sink: CommandSink | None = None,
    watch: Watch | None = None,
    flush: bool = False,
) -> Counters:
    """Counters of the work on the machine; the DRAM's commands go to `sink`; with `flush` dirty lines are written back.

    Loads only the model asked for: each brings a heavy library.
    """
    if model not in MODELS:
        raise ValueError(f"no model named {model!r}")
    simulate = import_module(f"archsim.machine.{model}").simulate
    counters: Counters = simulate(spec, work, progress, sink, watch=watch, flush=flush)
    return counters
