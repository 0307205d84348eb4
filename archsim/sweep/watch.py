"""Who is told how a sweep goes."""

from __future__ import annotations

from typing import Protocol

from archsim.sweep.job import Done


class Watch(Protocol):
    """Called by the conductor; `token` numbers a job."""

    def begin(self, points: int, finished: int) -> None:
        """So many points, so many of them finished before."""

    def started(self, token: int, what: str) -> None:
        """A job was handed out."""

    def rendered(self, token: int, done: Done) -> None:
        """A picture is there."""

    def ended(self, token: int, what: str, done: Done) -> None:
        """A point has its result, or has failed."""

    def look(self) -> None:
        """Some time has passed."""


class SilentWatch:
    """Tells nobody; counts what it is told."""

    def __init__(self) -> None:
        self.points = self.found = 0
        self.errors: list[str] = []

    def begin(self, points: int, finished: int) -> None:
        self.points, self.found = points, finished

    def started(self, token: int, what: str) -> None:
        pass

    def rendered(self, token: int, done: Done) -> None:
        pass

    def ended(self, token: int, what: str, done: Done) -> None:
        if done.error is not None:
            self.errors.append(done.error)

    def look(self) -> None:
        pass
