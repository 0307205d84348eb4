"""Chunks of work in a file: written as they are produced, read back one by one, never all in memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from archsim.trace.records import RECORD, Tasks


def write_chunks(path: Path, chunks: Iterable[tuple[Tasks, ...]]) -> None:
    """Draw the chunks, of one unit or several, to their end."""
    with path.open("wb") as stream:
        for chunk in chunks:
            for tasks in chunk:
                np.save(stream, tasks.starts)
                np.save(stream, tasks.records)


def read_chunks(path: Path, num_units: int) -> Iterator[tuple[Tasks, ...]]:
    """What `write_chunks` wrote."""
    tasks = _tasks(path)
    return zip(*[tasks] * num_units, strict=True)  # each tuple takes the next num_units of them


def _tasks(path: Path) -> Iterator[Tasks]:
    with path.open("rb") as stream:
        while stream.peek(1):
            yield Tasks(np.load(stream), np.load(stream).view(RECORD))
