"""The same verbs for Python as on the command line: load, simulate, sweep, reproduce, report.

`archsim.simulate("tiny")` in a notebook shows what the command prints; what is returned has pandas frames.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from archsim.cli.configs import find_config, find_run
from archsim.config import (
    Loaded,
    LoadedRun,
    RunConfig,
    load_run_with_origins,
    load_sweep_with_origins,
    resolved_yaml,
    run_path,
    sweep_of,
)
from archsim.config.explain import flat, origins
from archsim.errors import Location, fail
from archsim.report.comparison_page import comparison_report
from archsim.report.reproduction_page import reproduction_report
from archsim.report.run_page import run_report
from archsim.report.sweep_page import sweep_report
from archsim.reproduce.cells import Cell
from archsim.reproduce.papers import paper_named
from archsim.reproduce.reproduction import Reproduction, Row
from archsim.run import simulate as simulate_run
from archsim.run.folder import load_folder, plain, write_whole
from archsim.run.manifest import common_manifest, make_manifest
from archsim.run.progress import Progress, silent
from archsim.run.result import Result
from archsim.sweep.analysis import finished, pareto_front, sensitivity
from archsim.sweep.expand import overrides as override_texts
from archsim.sweep.plan import make_plan
from archsim.sweep.start import run_sweep
from archsim.sweep.store import INDEX, check_folder
from archsim.sweep.table import load_table, metrics_of, parameters_of, write_table
from archsim.sweep.watch import SilentWatch
from archsim.sweep.workers import LocalWorkers, OwnProcess

Changes = Mapping[str, Any] | Sequence[str]  # {"dotted.path": value}, or ["dotted.path=value"]


class Simulated(NamedTuple):
    """A finished run with what it was made of."""

    loaded: LoadedRun
    result: Result
    wall_seconds: float

    @property
    def config(self) -> RunConfig:
        return self.loaded.config

    def frame(self) -> pd.DataFrame:
        """A row for each statistic: value, unit, description."""
        return pd.DataFrame(self.result.statistics).set_index("name")

    def __getitem__(self, name: Any) -> Any:
        """The statistic of that name."""
        return self.result.value(name) if isinstance(name, str) else tuple.__getitem__(self, name)

    def _repr_html_(self) -> str:
        frame = pd.DataFrame({"value": self.result.summary})
        return f"<h4>{self.result.name}</h4>{frame.to_html()}"


class Swept(NamedTuple):
    """A sweep's folder and its table."""

    folder: Path
    table: pd.DataFrame

    def pareto(self, *columns: str) -> pd.DataFrame:
        """The points that no other point beats in the columns, by default in the sweep's metrics."""
        return pareto_front(self.table, columns or metrics_of(self.folder, self.table))

    def sensitivity(self, metric: str) -> pd.DataFrame:
        """How much each parameter moves a metric."""
        return sensitivity(self.table, parameters_of(self.folder), metric)

    def points(self) -> pd.DataFrame:
        """Parameters and metrics of the points that have a result."""
        columns = [*parameters_of(self.folder), *metrics_of(self.folder, self.table)]
        return finished(self.table)[list(dict.fromkeys(columns))]

    def _repr_html_(self) -> str:
        return f"<h4>{self.folder}</h4>{self.points().to_html()}"


class Reproduced(NamedTuple):
    """A paper's tables: printed and ours."""

    paper: str
    found: Reproduction

    @property
    def cells(self) -> list[Cell]:
        return self.found.cells

    @property
    def rows(self) -> Mapping[str, Row]:
        """The simulated runs by name."""
        return self.found.rows

    def frame(self) -> pd.DataFrame:
        """A row for each cell of the paper's tables."""
        return pd.DataFrame(self.cells)

    def _repr_html_(self) -> str:
        return f"<h4>{self.paper}</h4>{self.frame().to_html()}"


def load(run: str | Path, changes: Changes = ()) -> LoadedRun:
    """The `config` of a file or packaged run, and the `origins` of its values.

    Raises ArchsimError, as all of these functions.
    """
    texts = override_texts(changes) if isinstance(changes, Mapping) else changes
    return load_run_with_origins(find_run(str(run)), texts)


def simulate(
    run: LoadedRun | RunConfig | str | Path, changes: Changes = (), progress: Progress = silent
) -> Simulated:
    """Simulate a run: loaded, a configuration, a file, or a packaged run's name; of the latter two with changes."""
    if isinstance(run, Loaded | RunConfig) and changes:
        raise fail("a loaded configuration takes no changes", hint="give them to archsim.load")
    if isinstance(run, RunConfig):
        loaded = _in_python(run)
    else:
        loaded = run if isinstance(run, Loaded) else load(run, changes)

    started = time.perf_counter()
    with loaded.locating():
        result = simulate_run(loaded.config, progress)
    return Simulated(loaded, result, time.perf_counter() - started)


def sweep(file: str | Path | Mapping[str, Any], out: str | Path | None = None, jobs: int = 1) -> Swept:
    """Do what is not finished of a sweep: a file, a packaged sweep's name, or a mapping of a file's keys.

    With `jobs` above 1 other processes do the work; a script needs `if __name__ == "__main__":` then.
    """
    if isinstance(file, Mapping):
        loaded = sweep_of(plain(file))
        run = find_run(loaded.config.run)
    else:
        path = Path(find_config("sweeps", str(file)))
        loaded = load_sweep_with_origins(path)
        run = run_path(loaded.config.run, path.parent)
    folder = Path(out) if out is not None else Path("runs") / f"sweep-{loaded.config.name}"
    check_folder(folder)
    plan = make_plan(loaded.config, run)
    workers = LocalWorkers(jobs) if jobs > 1 else OwnProcess()
    run_sweep(loaded, run, (plan, plan), folder, (workers, "1of1", SilentWatch()))
    write_table(folder)
    return Swept(folder, load_table(folder))


def reproduce(paper: str = "johnson2004", progress: Progress = silent) -> Reproduced:
    """Simulate what a paper's tables are about; other processes do the work, see `sweep`."""
    return Reproduced(paper, paper_named(paper).reproduce(progress))


def report(what: Simulated | Swept | Reproduced | str | Path | Sequence[str | Path], out: str | Path) -> Path:
    """Write the HTML page of a run, sweep or reproduction, or of several run folders side by side; returns its path."""
    if isinstance(what, Simulated):
        page = _run_page(what)
    elif isinstance(what, Swept):
        page = sweep_report(what.folder)
    elif isinstance(what, Reproduced):
        page = _reproduction_page(what)
    else:
        page = _page_of_folders(
            [Path(folder) for folder in ([what] if isinstance(what, str | Path) else what)]
        )
    write_whole(Path(out), page)
    return Path(out)


def _page_of_folders(folders: list[Path]) -> str:
    if len(folders) == 1 and (folders[0] / INDEX).is_file():
        return sweep_report(folders[0])
    return comparison_report([load_folder(folder) for folder in folders])


def _reproduction_page(what: Reproduced) -> str:
    seconds = sum(row.wall_seconds for row in what.rows.values())
    manifest = common_manifest(["archsim.reproduce"], seconds)
    return reproduction_report(paper_named(what.paper).PAPER, what.found, manifest, links={})


def _run_page(run: Simulated) -> str:
    text, digest = resolved_yaml(run.config), run.result.scene_digest
    manifest = make_manifest(text, run.config.seed, digest, ["archsim.simulate"], run.wall_seconds)
    return run_report(run.result, text, manifest, origins(run.loaded))


def _in_python(config: RunConfig) -> LoadedRun:
    """A configuration that was made or changed in Python, which is what set its values."""
    keys = (key for key, _ in flat(config.model_dump(mode="json")))
    return LoadedRun(config, dict.fromkeys(keys, Location("Python")))
