"""How fast this computer simulates: both phases of an irregular shadow map, kernels, timing and caches apart."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from archsim.config import RunConfig, load_run
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.compiled import simulate
from archsim.machine.entry import path_from
from archsim.model.cache.functional import new_chain, replay
from archsim.run.izb_subject import subject_of
from archsim.run.izb_work import prepare
from archsim.run.progress import Progress, silent
from archsim.trace.records import Op, Tasks, num_instructions
from archsim.trace.stream import Work

RUN = "runs/izb_bloodprison_light0.yaml"
OVERRIDES = ("scene.resolution=[640, 512]",)
CACHE_REPLAY = "cache.replay"
REPETITIONS = 3  # the fastest counts: other work on the computer only ever slows one down
UNITS = {CACHE_REPLAY: "accesses/s"}
_MEBIBYTE = 2**20


class Row(NamedTuple):
    """One measurement."""

    name: str
    value: float
    unit: str


def measure(overrides: tuple[str, ...] = OVERRIDES, progress: Progress = silent) -> list[Row]:
    """All measurements; the first repetition compiles and is not counted."""
    config = load_run(RUN, overrides)
    best: dict[str, float] = {}
    for repetition in range(REPETITIONS + 1):
        progress("measuring", repetition, REPETITIONS + 1)
        for name, speed in _speeds(config).items():
            if repetition > 0:
                best[name] = max(best.get(name, 0.0), speed)
    progress("measuring", 1, 1)
    rows = [
        Row(name, round(speed), UNITS.get(name, "simulated instructions/s")) for name, speed in best.items()
    ]
    return [*rows, Row("peak_memory", round(_peak_bytes() / _MEBIBYTE, 1), "MiB")]


def _speeds(config: RunConfig) -> dict[str, float]:
    """Speeds of everything, once, on the light view with the most samples."""
    view = max(prepare(config, subject_of(config)), key=lambda view: int(view.plan.face.taken.sum()))
    speeds: dict[str, float] = {}
    accesses = []
    for phase, work in (("izb_build", view.build), ("izb_raster", view.raster)):
        found, chunks = _phase(phase_machine(config.machine, phase), work())
        speeds |= {f"{phase}.{what}": speed for what, speed in found.items()}
        accesses += [_accesses(tasks.records) for tasks in chunks]
    return speeds | {CACHE_REPLAY: _cache_replay(config, np.concatenate(accesses))}


def _phase(machine: PhaseMachine, work: Work) -> tuple[dict[str, float], list[Tasks]]:
    """Instructions a second that the interpreter executes and that the timing layer plays, and the work."""
    chunks, interpreting = _timed(lambda: list(work.chunks))
    instructions = sum(num_instructions(tasks) for tasks in chunks)
    _, timing = _timed(lambda: simulate(machine.spec, Work(work.num_tasks, iter(chunks))))
    return {"timing": instructions / timing, "interpret": instructions / interpreting}, chunks


def _accesses(records: np.ndarray) -> np.ndarray:
    """The loads and stores among the records."""
    return records[(records["op"] == Op.LOAD) | (records["op"] == Op.STORE)]


def _cache_replay(config: RunConfig, accesses: np.ndarray) -> float:
    """Accesses a second through the first L1 of the build phase and the L2, without time."""
    machine = phase_machine(config.machine, "izb_build")
    chain = new_chain([machine.spec.caches[k] for k in path_from(machine, 0)])
    addresses, sizes = accesses["address"].copy(), accesses["bytes"].astype(np.int64)
    _, seconds = _timed(lambda: replay(chain, addresses, sizes, accesses["op"] == Op.STORE))
    return len(accesses) / seconds


def _timed(action: Callable[[], Any]) -> tuple[Any, float]:
    """What the action returns, and the seconds it took."""
    started = time.perf_counter()
    result = action()
    return result, time.perf_counter() - started


def _peak_bytes() -> int:
    """The largest resident memory of this process so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
