"""`archsim report`."""

from __future__ import annotations

from pathlib import Path

from archsim.errors import Location, fail
from archsim.report.comparison_page import comparison_report
from archsim.report.sweep_page import sweep_report
from archsim.run.folder import load_folder, write_whole
from archsim.sweep.store import INDEX


def report(folders: list[Path], out: Path | None) -> None:
    """Write the page of a sweep, or one that compares runs; say where it is."""
    if len(folders) == 1 and (folders[0] / INDEX).is_file():
        page, target = sweep_report(folders[0]), out or folders[0] / "report.html"
    elif len(folders) == 1:
        load_folder(folders[0])
        raise fail("has its report already: report.html", Location(str(folders[0])), "name several runs")
    else:
        page, target = comparison_report([load_folder(f) for f in folders]), out or Path("comparison.html")
    write_whole(target, page)
    print(f"written to {target}")
