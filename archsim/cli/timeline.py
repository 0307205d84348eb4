"""`archsim timeline`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from archsim.cli.configs import find_run
from archsim.config import load_run
from archsim.errors import did_you_mean, fail
from archsim.machine.build import phase_machine
from archsim.machine.spec import MachineSpec
from archsim.machine.timeline import record
from archsim.report.perfetto import perfetto
from archsim.report.waterfall import waterfall, waterfall_figure
from archsim.run.folder import write_whole
from archsim.run.izb_statistics import BUILD, RASTER
from archsim.run.izb_work import Recorded, replay
from archsim.run.kinds import kind_of
from archsim.trace.records import Tasks
from archsim.trace.stream import Work, whole

PHASES = (BUILD, RASTER)


def timeline(run: str, overrides: list[str], phase: str, window: tuple[str, str | None], out: Path) -> None:
    """Play some tasks of a phase on the reference model; write the trace, print the cycles asked for."""
    config = load_run(find_run(run), overrides)
    if phase not in PHASES or not config.workload.kind.startswith("izb"):
        hint = did_you_mean(phase, PHASES) or f"phases of irregular shadow mapping: {', '.join(PHASES)}"
        raise fail(f"no timeline of '{phase}'", hint=hint)
    rendering = kind_of(config).rendering
    assert rendering is not None
    machine = phase_machine(config.machine, phase)
    (view, *_) = rendering.render(config).views or [None]
    if view is None:
        raise fail("the picture is empty: there is no work")
    found = record(machine.spec, whole(_cut(view, phase, machine.spec, parse_range(window[0]))))
    write_whole(out, perfetto(found, machine.cache_names, machine.tick_hertz))
    if window[1] is not None:
        first, last = parse_range(window[1])
        print(waterfall(found, first, last - first), end="")
        write_whole(out.with_suffix(".svg"), waterfall_figure(found, first, last - first))
    print(f"{len(found.slots):,} issue slots in {found.counters.cycles:,} cycles")
    print(f"written to {out} (open it with https://ui.perfetto.dev)")


def parse_range(text: str) -> tuple[int, int]:
    """`100:300` as (100, 300); `300` starts at 0."""
    first, colon, last = text.rpartition(":")
    if not last.isdigit() or (colon and not first.isdigit()) or int(last) <= int(first or 0):
        raise fail(f"a range is written FIRST:LAST or LAST, with FIRST below LAST, not '{text}'")
    return int(first or 0), int(last)


def _cut(view: Recorded, phase: str, spec: MachineSpec, window: tuple[int, int]) -> Tasks:
    """Tasks FIRST to LAST - 1 of a phase, as one chunk."""
    work: Work = replay(view, phase, spec)
    first, last = window
    kept, done = [], 0
    for tasks in work.chunks:
        low, high = max(first - done, 0), min(last - done, tasks.num_tasks)
        kept += [tasks.records[tasks.starts[k] : tasks.starts[k + 1]] for k in range(low, max(low, high))]
        done += tasks.num_tasks
    if not kept:
        raise fail(f"the phase has {done} tasks, none of them from {first} on")
    starts = np.cumsum([0, *(len(records) for records in kept)]).astype(np.int64)
    return Tasks(starts, np.concatenate(kept))
