"""How fast this computer simulates: kernels, timing and caches of an irregular shadow map, a DRAM alone, a pipeline."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from archsim.config import RunConfig, load_machine, load_run
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.compiled import simulate
from archsim.machine.dram_alone.compiled import simulate as serve
from archsim.machine.dram_alone.stream import Requests
from archsim.machine.entry import path_from
from archsim.machine.pipeline.build import pipeline_machine
from archsim.machine.pipeline.play import play
from archsim.model.cache.functional import new_chain, replay
from archsim.run.izb_subject import subject_of
from archsim.run.izb_work import prepare, takes
from archsim.run.progress import Progress, silent
from archsim.trace.records import RECORD, Op, Tasks, num_instructions
from archsim.trace.stream import PipelineWork, Work

RUN = "runs/izb_bloodprison_light0.yaml"
OVERRIDES = ("scene.resolution=[640, 512]",)
CACHE_REPLAY = "cache.replay"
DRAM_RANDOM, DRAM_SEQUENTIAL = "dram.random", "dram.sequential"
DRAM_REQUESTS = 500_000
REPETITIONS = 3  # the fastest counts: other work on the computer only ever slows one down
PIPELINE = "pipeline.timing"
PIPELINE_TILES = 1 << 17
UNITS = {
    CACHE_REPLAY: "accesses/s",
    DRAM_RANDOM: "requests/s",
    DRAM_SEQUENTIAL: "requests/s",
    PIPELINE: "tasks/s",
}
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
    views = prepare(config.workload, takes(config), subject_of(config))
    view = max(views, key=lambda view: int(view.plan.face.taken.sum()))
    speeds: dict[str, float] = {}
    accesses = []
    for phase, work in (("izb_build", view.build), ("izb_raster", view.raster)):
        found, chunks = _phase(phase_machine(config.machine, phase), work())
        speeds |= {f"{phase}.{what}": speed for what, speed in found.items()}
        accesses += [_accesses(tasks.records) for tasks in chunks]
    speeds[CACHE_REPLAY] = _cache_replay(config, np.concatenate(accesses))
    return speeds | _dram_alone(config) | {PIPELINE: _pipeline()}


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


def _dram_alone(config: RunConfig) -> dict[str, float]:
    """Read requests a second of the machine's DRAM, each as soon as there is room for it."""
    machine = phase_machine(config.machine, "izb_build")
    line_bytes = machine.spec.caches[-1].line_bytes
    num_lines = machine.dram_bytes // line_bytes
    streams = {
        DRAM_RANDOM: np.random.default_rng(config.seed).integers(0, num_lines, DRAM_REQUESTS),
        DRAM_SEQUENTIAL: np.arange(DRAM_REQUESTS) % num_lines,
    }
    speeds = {}
    for name, lines in streams.items():
        nothing = np.zeros(DRAM_REQUESTS, np.int64)
        requests = Requests(lines * line_bytes, nothing.astype(np.bool_), nothing)
        _, seconds = _timed(partial(serve, machine.spec.dram, line_bytes, [requests]))
        speeds[name] = DRAM_REQUESTS / seconds
    return speeds


def _pipeline() -> float:
    """Tasks a second of four units that draw tiles: two hand them on, one reads depths, one updates a stencil."""
    machine = pipeline_machine(load_machine("machines/aila2004.yaml"))
    tile = np.arange(PIPELINE_TILES) * 37 % 20480  # of 1280 x 1024 pixels
    depth, stencil = tile * 128, (1 << 22) + tile * 64
    plain, take = (Op.EMIT, 2, 0, 0), (Op.TAKE, 0, 0, 0)
    pass_on = (Op.EMIT, 0, 0, 0)
    work = {
        "geometry": _repeated([plain], {}),
        "rasterizer": _repeated([take, pass_on], {}),
        "depth": _repeated([(Op.TAKE, 1, 0, 0), (Op.LOAD, 0, 0, 128), pass_on], {1: depth}),
        "stencil": _repeated([take, (Op.LOAD, 0, 0, 64), (Op.STORE, 0, 64, 64)], {1: stencil, 2: stencil}),
    }
    nothing = Tasks(np.zeros(1, np.int64), np.zeros(0, RECORD))
    chunk = tuple(work.get(unit, nothing) for unit in machine.units)
    _, seconds = _timed(lambda: play("compiled", machine, PipelineWork(machine.units, iter([chunk]))))
    return len(work) * PIPELINE_TILES / seconds


def _repeated(task: list[tuple[int, int, int, int]], addresses: dict[int, np.ndarray]) -> Tasks:
    """PIPELINE_TILES tasks of (operation, address, steps, bytes) each, some records with addresses of their own."""
    once = [(address, steps, size, op) for op, address, steps, size in [*task, (Op.END, 0, 0, 0)]]
    records = np.tile(np.array(once, RECORD), PIPELINE_TILES)
    for place, own in addresses.items():
        records["address"][place :: len(once)] = own
    return Tasks(np.arange(PIPELINE_TILES + 1) * len(once), records)


def _timed(action: Callable[[], Any]) -> tuple[Any, float]:
    """What the action returns, and the seconds it took."""
    started = time.perf_counter()
    result = action()
    return result, time.perf_counter() - started


def _peak_bytes() -> int:
    """The largest resident memory of this process so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
