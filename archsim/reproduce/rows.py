"""The rows of a paper's tables, simulated from the files in experiments/."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from archsim import resources
from archsim.config import Loaded
from archsim.reproduce.processes import in_processes
from archsim.reproduce.reproduction import Row
from archsim.run.progress import Progress
from archsim.run.result import Result


def simulate_rows(
    names: Iterable[str], simulate_row: Callable[[str, Progress], Row], progress: Progress
) -> dict[str, Row]:
    """Every row by name, simulated two at a time."""
    listed = list(names)
    num_processes = min(2, os.cpu_count() or 1)
    rows = in_processes(simulate_row, [(name,) for name in listed], num_processes, progress)
    return dict(zip(listed, rows, strict=True))


def simulate_file(
    paper: str,
    name: str,
    load: Callable[..., Loaded[Any]],
    simulate: Callable[[Any, Progress], Result],
    progress: Progress,
    overrides: Sequence[str] = (),
) -> Row:
    """The row of experiments/PAPER/NAME.yaml; its name stands before what the progress says."""

    def named(what: str, done: int, total: int) -> None:
        progress(f"{name} {what}", done, total)

    loaded = load(resources.experiment(paper) / f"{name}.yaml", overrides)
    started = time.perf_counter()
    result = simulate(loaded.config, named)
    return Row(loaded, result, time.perf_counter() - started)
