"""Conducting a sweep: every unfinished point once, its picture rendered once, whatever happens to any of them."""

from __future__ import annotations

import shutil
from collections import deque
from pathlib import Path
from typing import NamedTuple

from archsim.sweep.job import Done, PointJob, RenderJob
from archsim.sweep.plan import Point
from archsim.sweep.store import is_finished, sweep_out, write_failure
from archsim.sweep.watch import Watch
from archsim.sweep.workers import Workers

_SECONDS_BETWEEN_LOOKS = 0.2


class Group(NamedTuple):
    """Points that are played on the same work."""

    work: Path | None  # where it is kept; None: each point renders for itself
    points: deque[Point]


class Tally(NamedTuple):
    """How a sweep ended."""

    finished: int
    failed: int
    found: int  # finished before


def conduct(points: list[Point], folder: Path, workers: Workers, part: str, watch: Watch) -> Tally:
    """Do all points that are not finished; `part` names this process's share of the sweep."""
    points = list({point.digest: point for point in points}.values())  # values may be written in two ways
    unfinished = [point for point in points if not is_finished(folder, point.digest)]
    sweep_out(folder, (point.digest for point in unfinished), part)
    watch.begin(len(points), len(points) - len(unfinished))
    conductor = _Conductor(folder, workers, watch)
    for point in unfinished:
        if point.config is None:
            conductor.fail(0, point, Done(0.0, point.error))
    conductor.waiting.extend(_groups([p for p in unfinished if p.config is not None], folder / "work" / part))
    conductor.run()
    shutil.rmtree(folder / "work" / part, ignore_errors=True)
    failed = conductor.num_failed
    return Tally(len(unfinished) - failed, failed, len(points) - len(unfinished))


def _groups(points: list[Point], work: Path) -> list[Group]:
    """Points by their work; one that shares its work with no other needs none kept."""
    together: dict[str, list[Point]] = {}
    for point in points:
        together.setdefault(point.functional_digest or point.digest, []).append(point)
    return [
        Group(work / key if len(own) > 1 and own[0].functional_digest else None, deque(own))
        for key, own in together.items()
    ]


class _Conductor:
    """The state of a sweep under way."""

    def __init__(self, folder: Path, workers: Workers, watch: Watch):
        self.folder, self.workers, self.watch = folder, workers, watch
        self.waiting: deque[Group] = deque()  # not rendered yet
        self.rendering: dict[int, Group] = {}
        self.ready: deque[Group] = deque()  # with points to hand out
        self.playing: dict[int, tuple[Group, Point]] = {}
        self.left: dict[Path, int] = {}  # points that still need the work
        self.num_failed = 0
        self._token = 0

    def run(self) -> None:
        """Hand out jobs and take them back until none is left."""
        while self.waiting or self.rendering or self.ready or self.playing:
            while len(self.rendering) + len(self.playing) < self.workers.capacity and self._hand():
                pass
            for token, done in self.workers.take(_SECONDS_BETWEEN_LOOKS):
                self._back(token, done)
            self.watch.look()

    def fail(self, token: int, point: Point, done: Done) -> None:
        """Keep why the point has no result."""
        assert done.error is not None
        self.num_failed += 1
        write_failure(self.folder, point.digest, done.error, point.command)
        self.watch.ended(token, point.command, done)

    def _hand(self) -> bool:
        """Hand out one job; false if none can be now."""
        while self.waiting and self._should_open():
            group = self.waiting.popleft()
            if group.work is not None:
                self._render(group)
                return True
            self.ready.append(group)
        if not self.ready:
            return False
        self._play(self.ready[0])
        return True

    def _should_open(self) -> bool:
        """Whether to go to the next group: one ahead, so that nobody waits for work and little of it is kept."""
        points = sum(len(group.points) for group in self.ready)
        return points == 0 or (not self.rendering and points < 2 * self.workers.capacity)

    def _render(self, group: Group) -> None:
        config = group.points[0].config
        assert config is not None
        assert group.work is not None
        self._token += 1
        self.rendering[self._token] = group
        self.left[group.work] = len(group.points)
        self.watch.started(self._token, f"rendering for {len(group.points)} points")
        self.workers.hand(self._token, RenderJob(config, group.work))

    def _play(self, group: Group) -> None:
        point = group.points.popleft()
        if not group.points:
            self.ready.remove(group)
        assert point.config is not None
        self._token += 1
        self.playing[self._token] = (group, point)
        self.watch.started(self._token, point.command)
        job = PointJob(self.folder, point.digest, point.config, point.command, group.work)
        self.workers.hand(self._token, job)

    def _back(self, token: int, done: Done) -> None:
        """A job has ended."""
        if token in self.rendering:
            self._rendered(token, self.rendering.pop(token), done)
            return
        group, point = self.playing.pop(token)
        if done.error is None:
            self.watch.ended(token, point.command, done)
        else:
            self.fail(token, point, done)
        if group.work is not None:
            self.left[group.work] -= 1
            if self.left[group.work] == 0:
                shutil.rmtree(group.work, ignore_errors=True)

    def _rendered(self, token: int, group: Group, done: Done) -> None:
        if done.error is None:
            self.watch.rendered(token, done)
            self.ready.append(group)
            return
        for point in group.points:
            self.fail(token, point, done)
