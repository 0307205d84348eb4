"""`archsim timeline`, and `archsim run --timeline`."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from archsim.cli.configs import find_run
from archsim.config import RunConfig, load_run
from archsim.errors import did_you_mean, fail
from archsim.machine.build import PhaseMachine, phase_machine
from archsim.machine.pipeline.build import PipelineMachine
from archsim.machine.spec import MachineSpec
from archsim.machine.timeline import Timeline, Window, record
from archsim.report.perfetto import Labels, perfetto
from archsim.report.waterfall import waterfall, waterfall_figure
from archsim.run.folder import write_whole
from archsim.run.izb_statistics import BUILD, RASTER
from archsim.run.izb_work import Recorded, replay
from archsim.run.izb_work import record as record_work
from archsim.run.recording import record_cycles, record_tasks
from archsim.trace.records import Tasks
from archsim.trace.stream import Work, whole

PHASES = (BUILD, RASTER)
_VIEWER = "https://ui.perfetto.dev"


class Wanted(NamedTuple):
    """What of a run is recorded."""

    phase: str | None
    tasks: str | None  # FIRST:LAST
    unit: str | None  # of a pipeline, whose tasks they are
    cycles: str | None  # FIRST:LAST, instead
    waterfall: str | None  # cycles that are printed


def timeline(run: str, overrides: list[str], wanted: Wanted, out: Path) -> None:
    """Play a part of a run on the reference model; write the trace, print the cycles asked for."""
    config = load_run(find_run(run), overrides)
    if wanted.cycles is not None and wanted.tasks is not None:
        raise fail("--tasks and --cycles: one of them")
    is_izb = config.workload.kind.startswith("izb")
    if wanted.unit is not None and (is_izb or wanted.tasks is None):
        what = "irregular shadow mapping has no units" if is_izb else "name its tasks, too (--tasks)"
        raise fail(f"--unit: {what}")
    if is_izb and wanted.cycles is None:
        machine, found = _tasks(config, wanted.phase or RASTER, parse_window(wanted.tasks or "0:200"))
        _write(out, found, machine, wanted.waterfall)
        return
    if wanted.tasks is not None:
        recorded = record_tasks(config, parse_window(wanted.tasks), wanted.unit, wanted.phase)
    else:
        recorded = record_cycles(config, parse_window(wanted.cycles or "2000"), wanted.phase)
    for each in recorded:
        if wanted.tasks is not None:
            print(f"{each.phase}: cycles {each.window.first} to {each.window.last - 1}")
        place = out if len(recorded) == 1 else out.with_stem(f"{out.stem}-{each.phase}")
        _write(place, each.timeline, each.machine, wanted.waterfall)


def write_timelines(config: RunConfig, window: Window, folder: Path) -> list[str]:
    """Write what happens in some cycles of every phase of a run: a trace and waterfalls of each. Their phases."""
    recorded = record_cycles(config, window)
    for phase, machine, found, _ in recorded:
        write_whole(folder / f"timeline-{phase}.json", perfetto(found, _labels(machine)))
        write_whole(folder / f"waterfall-{phase}.txt", waterfall(found, _shown(window), _units(machine)))
        write_whole(
            folder / f"waterfall-{phase}.svg", waterfall_figure(found, _shown(window), _units(machine))
        )
    return [each.phase for each in recorded]


def _shown(window: Window) -> Window:
    """What of a window fits on a line and in a figure."""
    return Window(window.first, min(window.last, window.first + 400))


def _units(machine: PhaseMachine | PipelineMachine) -> tuple[str, ...]:
    return machine.units if isinstance(machine, PipelineMachine) else ()


def _labels(machine: PhaseMachine | PipelineMachine) -> Labels:
    if isinstance(machine, PipelineMachine):
        return Labels(machine.caches, machine.tick_hertz, machine.units, machine.channels)
    return Labels(machine.cache_names, machine.tick_hertz, channels=(machine.fifo or "",))


def _write(out: Path, found: Timeline, machine: PhaseMachine | PipelineMachine, shown: str | None) -> None:
    """Write the trace of a phase, and print and draw the cycles that are to be shown."""
    write_whole(out, perfetto(found, _labels(machine)))
    if shown is not None:
        window = parse_window(shown)
        print(waterfall(found, window, _units(machine)), end="")
        write_whole(out.with_suffix(".svg"), waterfall_figure(found, window, _units(machine)))
    print(f"written to {out} (open it with {_VIEWER})")


def _tasks(config: RunConfig, phase: str, window: Window) -> tuple[PhaseMachine, Timeline]:
    """Some tasks of a phase on cores, played by themselves."""
    if phase not in PHASES:
        hint = did_you_mean(phase, PHASES) or f"phases of irregular shadow mapping: {', '.join(PHASES)}"
        raise fail(f"no timeline of '{phase}'", hint=hint)
    machine = phase_machine(config.machine, phase)
    views = record_work(config)
    if not views:
        raise fail("the picture is empty: there is no work")
    return machine, record(machine.spec, whole(_cut(views[0], phase, machine.spec, window)))


def parse_window(text: str) -> Window:
    """`100:300` as the cycles from 100 to 299; `300` starts at 0."""
    first, colon, last = text.rpartition(":")
    if not last.isdigit() or (colon and not first.isdigit()) or int(last) <= int(first or 0):
        raise fail(f"a range is written FIRST:LAST or LAST, with FIRST below LAST, not '{text}'")
    return Window(int(first or 0), int(last))


def _cut(view: Recorded, phase: str, spec: MachineSpec, window: Window) -> Tasks:
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
