"""Where jobs are done: processes of this computer that stay, or a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from importlib import import_module
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from archsim.errors import fail
from archsim.reproduce.processes import end_with_parent
from archsim.sweep.job import Done, PointJob, RenderJob, perform

Job = RenderJob | PointJob


class Workers(Protocol):
    """At most `capacity` jobs are handed over at a time."""

    @property
    def capacity(self) -> int: ...

    def hand(self, token: int, job: Job) -> None:
        """Start a job."""

    def take(self, seconds: float) -> list[tuple[int, Done]]:
        """Jobs that have ended, after waiting for at most so long."""

    def close(self) -> None:
        """Stop whatever is running."""


class OwnProcess:
    """Does each job at once, in this process."""

    capacity = 1

    def __init__(self, perform: Callable[[Any], Done] = perform):
        self._perform = perform
        self._ended: list[tuple[int, Done]] = []

    def hand(self, token: int, job: Job) -> None:
        self._ended.append((token, self._perform(job)))

    def take(self, seconds: float) -> list[tuple[int, Done]]:
        ended, self._ended = self._ended, []
        return ended

    def close(self) -> None:
        pass


class _Worker(NamedTuple):
    process: SpawnProcess
    connection: Connection


class LocalWorkers:
    """Processes that each do one job at a time; one that dies fails its job and is replaced.

    While nothing has been compiled for this code, one process works alone until a point has been played: the others
    then find what it compiled, instead of compiling the same beside it.
    """

    def __init__(self, capacity: int, perform: Callable[[Any], Done] = perform, is_cold: bool | None = None):
        self._most = capacity
        self._compiles = nothing_compiled() if is_cold is None else is_cold
        self._perform = perform
        self._points: set[int] = set()  # jobs under way that play a point
        self._idle: list[_Worker] = []
        self._busy: dict[int, _Worker] = {}

    @property
    def capacity(self) -> int:
        """Jobs that may be handed over at a time."""
        return 1 if self._compiles else self._most

    def hand(self, token: int, job: Job) -> None:
        if not isinstance(job, RenderJob):
            self._points.add(token)
        if not self._idle and not self._busy:  # all at once, so that they load while the first job is done
            self._idle = [_started(self._perform) for _ in range(self._most)]
        worker = self._idle.pop() if self._idle else _started(self._perform)
        self._busy[token] = worker
        try:
            worker.connection.send(job)
        except OSError:  # it died while idle
            self._busy[token] = worker = _started(self._perform)
            worker.connection.send(job)

    def take(self, seconds: float) -> list[tuple[int, Done]]:
        ready = wait([worker.connection for worker in self._busy.values()], seconds)
        ended = [token for token, worker in self._busy.items() if worker.connection in ready]
        return [(token, self._receive(token)) for token in ended]

    def close(self) -> None:
        for worker in [*self._idle, *self._busy.values()]:
            worker.process.terminate()
            worker.connection.close()
        for worker in [*self._idle, *self._busy.values()]:
            worker.process.join()

    def _receive(self, token: int) -> Done:
        worker = self._busy.pop(token)
        self._compiles = self._compiles and token not in self._points
        try:
            done: Done = worker.connection.recv()
        except (EOFError, OSError):
            worker.process.join()
            return Done(0.0, f"the process that did it ended early, with exit code {worker.process.exitcode}")
        self._idle.append(worker)
        return done


def nothing_compiled() -> bool:
    """Whether the compiler's cache for this code is empty."""
    return not any(Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.nbi"))


class DaskWorkers:
    """The threads of a Dask cluster; its workers must see the sweep's folder under the same path."""

    def __init__(self, address: str):
        """Raises ArchsimError if there is no Dask here, or no scheduler there."""
        try:
            from distributed import Client
        except ImportError:
            raise fail("--scheduler needs Dask", hint="pip install 'archsim[cluster]'") from None
        try:
            self._client = Client(address)
        except (OSError, ValueError) as error:
            raise fail(f"no Dask scheduler at '{address}': {error}") from None
        self.capacity = max(1, sum(self._client.nthreads().values()))
        self._running: dict[Any, int] = {}

    def hand(self, token: int, job: Job) -> None:
        self._running[self._client.submit(perform, job, pure=False)] = token

    def take(self, seconds: float) -> list[tuple[int, Done]]:
        from distributed import wait as wait_for

        try:
            ended = wait_for(list(self._running), timeout=seconds, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            return []
        return [(self._running.pop(future), _outcome(future)) for future in ended]

    def close(self) -> None:
        self._client.cancel(list(self._running))
        self._client.close()


def _outcome(future: Any) -> Done:
    """What a Dask job came to; a cluster that lost it says so in an exception."""
    error = future.exception()
    return Done(0.0, f"the cluster lost it: {error!r}") if error else future.result()


def _started(perform: Callable[[Any], Done]) -> _Worker:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(theirs, perform), daemon=True)
    process.start()
    theirs.close()
    return _Worker(process, ours)


def _work(connection: Connection, perform: Callable[[Any], Done]) -> None:
    """The body of a local worker: do jobs until the parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides when to stop
    threading.Thread(target=end_with_parent, daemon=True).start()
    import_module("archsim.machine.compiled")  # slow to load, and whatever comes will need it
    while True:
        connection.send(perform(connection.recv()))
