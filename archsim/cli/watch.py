"""A sweep under way as a live table on stderr: jobs that run, points done, failures, what is left."""

from __future__ import annotations

import time
from types import TracebackType

from rich import box
from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from archsim.cli.console import terminal
from archsim.sweep.job import Done

_SHOWN_FAILURES = 5


class LiveTable:
    """A `sweep.watch.Watch`. Use as a context manager; silent when stderr is not a terminal."""

    def __init__(self, console: Console | None = None) -> None:
        self._console = console or terminal(stderr=True)
        self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self._running: dict[int, tuple[str, float]] = {}
        self._failures: list[str] = []
        self._points = self._found = self._done = 0
        self._began = time.monotonic()

    def __enter__(self) -> LiveTable:
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self._live.stop()

    def begin(self, points: int, finished: int) -> None:
        self._points, self._found, self._began = points, finished, time.monotonic()

    def started(self, token: int, what: str) -> None:
        self._running[token] = (what, time.monotonic())

    def rendered(self, token: int, done: Done) -> None:
        self._running.pop(token, None)

    def ended(self, token: int, what: str, done: Done) -> None:
        self._running.pop(token, None)
        self._done += 1
        if done.error is not None:
            self._failures.append(f"{done.error.splitlines()[-1]}  [{what}]")

    def look(self) -> None:
        if self._console.is_terminal:
            self._live.update(self.picture(), refresh=True)

    def picture(self) -> Group:
        """What is shown now."""
        now = time.monotonic()
        jobs = Table(box=box.SIMPLE_HEAD, pad_edge=False, expand=True)
        jobs.add_column("running", overflow="fold", ratio=1)
        jobs.add_column("seconds", justify="right")
        for what, began in self._running.values():
            jobs.add_row(what, f"{now - began:.1f}")
        finished = self._found + self._done
        bar = ProgressBar(total=max(self._points, 1), completed=finished, width=40)
        failures = [Text(text, style="red") for text in self._failures[-_SHOWN_FAILURES:]]
        return Group(jobs, bar, Text(f" {self._line(now, finished)}"), *failures)

    def _line(self, now: float, finished: int) -> str:
        left = (self._points - finished) * (now - self._began) / self._done if self._done else None
        estimate = "" if left is None else f", about {_duration(left)} left"
        failed = f", {len(self._failures)} failed" if self._failures else ""
        return f"{finished} of {self._points} points{failed}{estimate}"


def _duration(seconds: float) -> str:
    whole = int(seconds + 0.5)
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"
