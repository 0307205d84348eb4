"""`archsim reproduce PAPER --figure NUMBER`."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from archsim.cli.bars import Bars
from archsim.cli.console import terminal
from archsim.errors import fail
from archsim.report.figures import quality_plot
from archsim.report.formats import number
from archsim.reproduce import johnson2004, johnson2004_figure8
from archsim.run.folder import MANIFEST, as_json, check_target, publish
from archsim.run.manifest import common_manifest
from archsim.shadow.map_quality import Point

FIGURES = {(johnson2004.ID, johnson2004_figure8.NUMBER): johnson2004_figure8}


def reproduce_figure(paper: str, figure: int, out: Path | None, json_only: bool) -> None:
    """Measure, leave a folder with plot and numbers, print them."""
    if (paper, figure) not in FIGURES:
        there = ", ".join(f"{name} --figure {number}" for name, number in FIGURES)
        raise fail(f"no figure {figure} of '{paper}'", hint=f"there are: {there}")
    module = FIGURES[paper, figure]
    target = out or Path("runs") / f"reproduce-{paper}-figure{figure}"
    check_target(target)

    started = time.perf_counter()
    with Bars() as bars:
        points = module.reproduce(bars)
    seconds = time.perf_counter() - started
    folder = publish(target, True, lambda folder: _fill(folder, module.TITLE, points, seconds))

    if json_only:
        print(_points_json(points), end="")
    else:
        _print(f"Figure {figure}. {module.TITLE}", points)
        print(f"written to {folder} (open {folder}/figure.svg)")


def _fill(folder: Path, title: str, points: Sequence[Point], seconds: float) -> None:
    (folder / "figure.svg").write_text(quality_plot(title, points), encoding="utf-8")
    (folder / "points.json").write_text(_points_json(points), encoding="utf-8")
    (folder / MANIFEST).write_text(as_json(common_manifest(sys.argv, seconds)), encoding="utf-8")


def _print(title: str, points: Sequence[Point]) -> None:
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    table.add_column("method")
    table.add_column("samples", justify="right")
    table.add_column("L2 error", justify="right")
    for point in points:
        table.add_row(point.method, number(point.num_samples), f"{point.l2:.5f}")
    terminal().print(table)


def _points_json(points: Sequence[Point]) -> str:
    return as_json([point._asdict() for point in points])
