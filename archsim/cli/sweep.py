"""`archsim sweep`, and what can be asked of a sweep's folder."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pandas as pd
import typer
from rich import box
from rich.table import Table

from archsim.cli.configs import find_config
from archsim.cli.console import terminal
from archsim.cli.edge import FAILED_CHECK
from archsim.cli.watch import LiveTable
from archsim.config import load_sweep_with_origins, run_path
from archsim.errors import Location, fail
from archsim.report.formats import number
from archsim.report.sweep_page import sweep_report
from archsim.run.folder import write_whole
from archsim.sweep.analysis import finding, finished, knee, pareto_front, sensitivity
from archsim.sweep.conduct import Tally
from archsim.sweep.plan import Point, make_plan, shard
from archsim.sweep.start import run_sweep
from archsim.sweep.store import check_folder, read_index
from archsim.sweep.table import check_metrics, load_table, metrics_of, parameters_of, write_table
from archsim.sweep.workers import DaskWorkers, LocalWorkers, Workers


def sweep(file: str, out: Path | None, workers: tuple[int, str | None], part: str, dry_run: bool) -> None:
    """Do what is not done yet of a sweep; leave its table. Exit code 1 if a point failed."""
    path = Path(find_config("sweeps", file))
    loaded = load_sweep_with_origins(path)
    run = run_path(loaded.config.run, path.parent)
    index, count = parse_shard(part)
    plan = make_plan(loaded.config, run)
    mine = shard(plan, index, count)
    if dry_run:
        _print_plan(plan, mine)
        return

    folder = out or Path("runs") / f"sweep-{loaded.config.name}"
    check_folder(folder)
    with LiveTable() as table:
        how = (_workers(*workers), f"{index}of{count}", table)
        tally = run_sweep(loaded, run, (plan, mine), folder, how)
    write_table(folder)
    write_whole(folder / "report.html", sweep_report(folder))
    _print_findings(folder)
    _print_tally(folder, tally)
    check_metrics(folder, load_table(folder))


def show_table(folder: Path, form: str, out: Path | None) -> None:
    """The table of a sweep: for people, as CSV, or as Parquet."""
    if form == "parquet":
        print(write_table(folder) if out is None else _parquet(load_table(folder), out))
        return
    table = load_table(folder)
    if form == "csv":
        table.to_csv(out or sys.stdout, index=False)
    elif form == "text":
        columns = [*parameters_of(folder), "status", *metrics_of(folder, table)]
        _print_frame(read_index(folder).name, table[list(dict.fromkeys(columns))])
    else:
        raise fail(f"no format '{form}'", hint="formats are text, csv, parquet")


def show_pareto(folder: Path, minimize: list[str]) -> None:
    """The points that no other point beats, the knee marked."""
    table = load_table(folder)
    columns = minimize or _metrics(folder, table)
    front = pareto_front(table, columns)
    best = knee(front, columns)
    shown = front[list(dict.fromkeys([*parameters_of(folder), *columns]))].copy()
    shown.insert(0, "", ["knee" if row == best else "" for row in range(len(front))])
    _print_frame(f"{len(front)} of {len(finished(table))} points on the Pareto front", shown)


def show_sensitivity(folder: Path, metric: str | None) -> None:
    """Which parameter moves a statistic most."""
    table = load_table(folder)
    chosen = metric or _metrics(folder, table)[0]
    _print_frame(f"What moves {chosen}", sensitivity(table, parameters_of(folder), chosen))
    print(finding(table, parameters_of(folder), chosen))


def _metrics(folder: Path, table: pd.DataFrame) -> list[str]:
    """The sweep's metrics. ArchsimError if no point has a result, or one of them is in none."""
    check_metrics(folder, table)
    if not len(finished(table)):
        raise fail("no point has a result", Location(str(folder)))
    return metrics_of(folder, table)


def parse_shard(text: str) -> tuple[int, int]:
    """`2/8` as (2, 8)."""
    index, slash, count = text.partition("/")
    if not (slash and index.isdigit() and count.isdigit() and 1 <= int(index) <= int(count)):
        raise fail(f"a shard is written I/N with 1 <= I <= N, not '{text}'")
    return int(index), int(count)


def _workers(jobs: int, scheduler: str | None) -> Workers:
    return DaskWorkers(scheduler) if scheduler else LocalWorkers(jobs)


def _parquet(table: pd.DataFrame, out: Path) -> Path:
    table.to_parquet(out, index=False)
    return out


def _print_plan(plan: list[Point], mine: list[Point]) -> None:
    for point in mine:
        print(point.command if point.error is None else f"{point.command}  # fails: {point.error}")
    pictures = len({point.functional_digest or point.digest for point in mine})
    print(f"{len(mine)} of {len(plan)} points, {pictures} pictures to render", file=sys.stderr)
    print(f"pictures and their work take from the machine: {_taken(mine)}", file=sys.stderr)


def _taken(points: list[Point]) -> str:
    """What the points' pictures take from their machines, and how many values of it there are."""
    values: dict[str, set[Any]] = {}
    for point in points:
        for name, value in point.from_machine.items():
            values.setdefault(name, set()).add(value)
    counted = (f"{name} ({len(own)} value{'s' * (len(own) > 1)})" for name, own in values.items())
    return ", ".join(counted) or "nothing"


def _print_findings(folder: Path) -> None:
    """A sentence for every metric that is a statistic, once all points are there."""
    table, parameters = load_table(folder), parameters_of(folder)
    if len(finished(table)) == len(table):
        for metric in metrics_of(folder, table):
            if metric not in parameters:
                print(finding(table, parameters, metric))


def _print_tally(folder: Path, tally: Tally) -> None:
    before = f", {tally.found} were finished before" if tally.found else ""
    print(f"{tally.finished} points finished, {tally.failed} failed{before}")
    print(f"written to {folder} (open {folder}/report.html)")
    if tally.failed:
        print(f"{tally.failed} points failed; why, and how to repeat them: {folder}/failed", file=sys.stderr)
        raise typer.Exit(FAILED_CHECK)


def _print_frame(title: str, frame: pd.DataFrame) -> None:
    """A table whose rows stay on a line each, however wide; names break at their dots."""
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in frame.columns:
        numeric = pd.api.types.is_numeric_dtype(frame[name])
        head = str(name).replace(".", ".\n")
        table.add_column(head, justify="right" if numeric else "left", no_wrap=True)
    for row in frame.itertuples(index=False):
        table.add_row(*(number(_plain(value)) for value in row))
    console = terminal()
    console.width = max(
        console.width, console.measure(table, options=console.options.update(width=10_000)).maximum
    )
    console.print(table)


def _plain(value: Any) -> Any:
    """The value as Python has it; None where there is none."""
    if pd.isna(value):
        return None
    return value.item() if hasattr(value, "item") else value
