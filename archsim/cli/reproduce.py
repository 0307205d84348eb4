"""`archsim reproduce`."""

from __future__ import annotations

import shutil
import sys
import time
from pathlib import Path

from archsim.cli.bars import Bars
from archsim.cli.console import print_tables
from archsim.cli.run import report_failed, run_files
from archsim.cli.walkthrough import frames_beside
from archsim.errors import fail
from archsim.report.reproduction_page import reproduction_report
from archsim.report.tables import tables
from archsim.reproduce import aila2004
from archsim.reproduce.papers import paper_named
from archsim.reproduce.reproduction import Reproduction
from archsim.run.folder import MANIFEST, as_json, check_target, fill_run, publish
from archsim.run.manifest import common_manifest
from archsim.run.progress import Progress


def reproduce(paper: str, out: Path | None, json_only: bool, frames: int | None = None) -> None:
    """Simulate the rows, leave a folder with their run folders and the report, print the tables."""
    module = paper_named(paper)
    if frames is not None and paper != aila2004.ID:
        raise fail(f"'{paper}' has no walkthroughs, so no frames", hint=f"papers with frames: {aila2004.ID}")
    target = out or Path("runs") / f"reproduce-{paper}"
    check_target(target)
    unfinished = frames_beside(target)

    started = time.perf_counter()
    with Bars() as bars:
        reproduction = _simulated(paper, bars, unfinished, frames)
    seconds = time.perf_counter() - started
    folder = publish(target, True, lambda folder: _fill(folder, paper, reproduction, seconds))

    shutil.rmtree(unfinished, ignore_errors=True)

    if json_only:
        print(_cells_json(reproduction), end="")
    else:
        print_tables(tables(module.PAPER, reproduction.cells))
        print(f"written to {folder} (open {folder}/report.html)")
    of_rows = [(row.result.name, check) for row in reproduction.rows.values() for check in row.result.checks]
    report_failed([*of_rows, *((paper, check) for check in reproduction.checks)])


def _simulated(paper: str, progress: Progress, unfinished: Path, frames: int | None) -> Reproduction:
    """The rows and cells; frames of walkthroughs are kept until all are there."""
    if paper == aila2004.ID:
        return aila2004.reproduce(progress, unfinished, [] if frames is None else [f"frames={frames}"])
    reproduction: Reproduction = paper_named(paper).reproduce(progress)
    return reproduction


def _fill(folder: Path, paper: str, reproduction: Reproduction, seconds: float) -> None:
    """Write the rows' run folders, the cells and the report, the manifest last."""
    manifest = common_manifest(sys.argv, seconds)
    for name, row in reproduction.rows.items():
        fill_run(folder / name, run_files(row.result, row.loaded, row.wall_seconds))
    links = {name: f"{name}/report.html" for name in reproduction.rows}
    report = reproduction_report(paper_named(paper).PAPER, reproduction, manifest, links)
    (folder / "report.html").write_text(report, encoding="utf-8")
    (folder / "cells.json").write_text(_cells_json(reproduction), encoding="utf-8")
    (folder / MANIFEST).write_text(as_json(manifest), encoding="utf-8")


def _cells_json(reproduction: Reproduction) -> str:
    return as_json([cell._asdict() for cell in reproduction.cells])
