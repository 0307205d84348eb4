"""`archsim reproduce`."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from types import ModuleType

from archsim.cli.bars import Bars
from archsim.cli.console import print_tables
from archsim.cli.run import report_failed, run_files
from archsim.errors import did_you_mean, fail
from archsim.report.reproduction_page import reproduction_report
from archsim.report.tables import tables
from archsim.reproduce import aila2004, johnson2004, lloyd2007
from archsim.reproduce.reproduction import Reproduction
from archsim.run.folder import MANIFEST, as_json, check_target, fill_run, publish
from archsim.run.manifest import common_manifest

PAPERS: dict[str, ModuleType] = {paper.ID: paper for paper in (johnson2004, aila2004, lloyd2007)}


def reproduce(paper: str, out: Path | None, json_only: bool) -> None:
    """Simulate the rows, leave a folder with their run folders and the report, print the tables."""
    if paper not in PAPERS:
        raise fail(f"no paper '{paper}'", hint=did_you_mean(paper, PAPERS) or f"papers: {', '.join(PAPERS)}")
    target = out or Path("runs") / f"reproduce-{paper}"
    check_target(target)

    started = time.perf_counter()
    with Bars() as bars:
        reproduction = PAPERS[paper].reproduce(bars)
    seconds = time.perf_counter() - started
    folder = publish(target, True, lambda folder: _fill(folder, paper, reproduction, seconds))

    if json_only:
        print(_cells_json(reproduction), end="")
    else:
        print_tables(tables(PAPERS[paper].PAPER, reproduction.cells))
        print(f"written to {folder} (open {folder}/report.html)")
    of_rows = [(row.result.name, check) for row in reproduction.rows.values() for check in row.result.checks]
    report_failed([*of_rows, *((paper, check) for check in reproduction.checks)])


def _fill(folder: Path, paper: str, reproduction: Reproduction, seconds: float) -> None:
    """Write the rows' run folders, the cells and the report, the manifest last."""
    manifest = common_manifest(sys.argv, seconds)
    for name, row in reproduction.rows.items():
        fill_run(folder / name, run_files(row.result, row.config, row.wall_seconds))
    results = {name: row.result for name, row in reproduction.rows.items()}
    report = reproduction_report(PAPERS[paper].PAPER, reproduction, results, manifest)
    (folder / "report.html").write_text(report, encoding="utf-8")
    (folder / "cells.json").write_text(_cells_json(reproduction), encoding="utf-8")
    (folder / MANIFEST).write_text(as_json(manifest), encoding="utf-8")


def _cells_json(reproduction: Reproduction) -> str:
    return as_json([cell._asdict() for cell in reproduction.cells])
