"""Several runs at once, each in a process of its own, with their progress told here."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

from archsim.errors import ArchsimError
from archsim.run.progress import Progress

_PROGRESS, _RESULT, _ERROR = range(3)
_SECONDS_BETWEEN_REPORTS = 0.1


def in_processes(
    function: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], num_processes: int, progress: Progress
) -> list[Any]:
    """[function(*job, progress) for each job], at most `num_processes` at a time.

    Raises the first ArchsimError of a job; then, and when interrupted, the other processes are stopped.
    """
    context = multiprocessing.get_context("spawn")
    results: dict[int, Any] = {}
    running: dict[Connection, tuple[int, SpawnProcess]] = {}
    waiting = list(enumerate(jobs))
    try:
        while waiting or running:
            while waiting and len(running) < num_processes:
                index, job = waiting.pop(0)
                ours, theirs = context.Pipe(duplex=False)
                process = context.Process(target=_work, args=(theirs, function, job), daemon=True)
                process.start()
                theirs.close()
                running[ours] = (index, process)
            for connection in wait(list(running)):
                assert isinstance(connection, Connection)
                index, process = running[connection]
                if _receive(connection, process, progress, index, results):
                    process.join()
                    del running[connection]
    finally:
        for _, process in running.values():
            process.terminate()
    return [results[index] for index in range(len(jobs))]


def _receive(
    connection: Connection, process: SpawnProcess, progress: Progress, index: int, results: dict[int, Any]
) -> bool:
    """Take one message; true when the job is done."""
    try:
        kind, content = connection.recv()
    except EOFError:
        process.join()
        raise RuntimeError(f"a worker process ended early, with exit code {process.exitcode}") from None
    if kind == _PROGRESS:
        progress(*content)
        return False
    if kind == _ERROR:
        error_type, problems = content
        raise error_type(problems)
    results[index] = content
    return True


def _work(connection: Connection, function: Callable[..., Any], job: tuple[Any, ...]) -> None:
    """The body of a worker process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides when to stop
    threading.Thread(target=end_with_parent, daemon=True).start()
    last_report = 0.0

    def tell(what: str, done: int, total: int) -> None:
        nonlocal last_report
        if done >= total or time.monotonic() - last_report > _SECONDS_BETWEEN_REPORTS:
            last_report = time.monotonic()
            connection.send((_PROGRESS, (what, done, total)))

    try:
        connection.send((_RESULT, function(*job, tell)))
    except ArchsimError as error:
        connection.send((_ERROR, (type(error), error.problems)))


def end_with_parent() -> None:
    """Leave when the parent is gone, however it went."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    wait([parent.sentinel])
    os._exit(1)
