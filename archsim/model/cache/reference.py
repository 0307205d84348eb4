"""A cache, to be believed: a process that looks up arrived requests at every core edge."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator
from enum import Enum
from typing import NamedTuple, Protocol

import simpy

from archsim.model.cache.spec import CacheSpec
from archsim.model.reference import Phase, at, call

Answer = Callable[[int, int], None]  # (tick, supplier): the data is here, from this level


class Kind(Enum):
    READ = "read"  # LOAD, or a child's fetch
    WRITE = "write"  # STORE
    WRITEBACK = "write-back"  # a child's dirty victim


class Request(NamedTuple):
    """What a cache or a channel is asked. A write-back wants no answer."""

    kind: Kind
    address: int
    num_bytes: int
    answer: Answer | None


class NextLevel(Protocol):
    """A cache's parent, or the DRAM."""

    def arrive(self, request: Request) -> None: ...


class Way:
    """The place of one line. `line` is the line's number, None when invalid."""

    def __init__(self) -> None:
        self.line: int | None = None
        self.is_coming = False
        self.is_dirty = False
        self.last_use = 0
        self.targets: list[Answer] = []
        self.fetch_tick = 0  # when the fetch reaches the next level


class Cache:
    """One cache. `sender` orders its requests among all that arrive at the next level in one tick."""

    def __init__(
        self,
        spec: CacheSpec,
        env: simpy.Environment,
        index: int,
        sender: int,
        period_ticks: int,
        parent: NextLevel,
    ):
        self.spec, self.env, self.index, self.sender, self.period_ticks = (
            spec,
            env,
            index,
            sender,
            period_ticks,
        )
        self.parent = parent
        self.sets = [[Way() for _ in range(spec.num_ways)] for _ in range(spec.num_sets)]
        self.input: deque[Request] = deque()
        self.busy_mshrs = 0
        self.sent = 0  # requests that have not yet arrived at the next level
        self.uses = 0  # accepted requests, the clock of LRU

        self.accepted = dict.fromkeys(Kind, 0)
        self.hits = self.merges = self.misses = 0
        self.fetches = self.writebacks_out = 0
        self.blocked = 0
        self.fetch_ticks = 0

    def is_quiet(self) -> bool:
        """Nothing waits here and nothing is on its way to or from the next level."""
        return not self.input and not self.busy_mshrs and not self.sent

    def arrive(self, request: Request) -> None:
        """`request` is here now."""
        self.input.append(request)

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: phase 2 of every core edge."""
        tick = 0
        while True:
            yield at(self.env, tick, Phase.LOOKUP, self.index)
            for _ in range(min(self.spec.num_ports, len(self.input))):
                if not self._accept(tick, self.input[0]):
                    self.blocked += 1
                    break
                self.input.popleft()
            tick += self.period_ticks

    def _accept(self, now: int, request: Request) -> bool:
        """Look up `request`; False when it cannot be accepted now, and nothing has changed."""
        line = request.address // self.spec.line_bytes
        ways = self.sets[line % self.spec.num_sets]
        way = next((way for way in ways if way.line == line), None)
        if way is None:
            way = self._miss(now, request, line, ways)
        elif way.is_coming:
            way = self._merge(request, way)
        else:
            self._hit(now, request)
        if way is None:
            return False

        self.accepted[request.kind] += 1
        self.uses += 1
        way.last_use = self.uses
        way.is_dirty = way.is_dirty or request.kind in (Kind.WRITE, Kind.WRITEBACK)
        return True

    def _hit(self, now: int, request: Request) -> None:
        self.hits += 1
        if request.answer is not None:
            tick = now + self.spec.hit_cycles * self.period_ticks
            call(at(self.env, tick, Phase.FILL), request.answer, tick, self.index)

    def _merge(self, request: Request, way: Way) -> Way | None:
        """The way whose line is on its way, or None when it has no free target."""
        if request.answer is not None:
            if len(way.targets) >= self.spec.num_targets:
                return None
            way.targets.append(request.answer)
        self.merges += 1
        return way

    def _miss(self, now: int, request: Request, line: int, ways: list[Way]) -> Way | None:
        """The way that now belongs to `line`, or None without a way or an MSHR."""
        way = _victim(ways)
        is_whole = request.kind is Kind.WRITEBACK and request.num_bytes == self.spec.line_bytes
        if way is None or (not is_whole and self.busy_mshrs >= self.spec.num_mshrs):
            return None

        self.misses += 1
        old_line, was_dirty = way.line, way.is_dirty
        way.line, way.is_dirty, way.is_coming = line, False, not is_whole
        if not is_whole:
            self._fetch(now, request, way)
        if was_dirty:
            assert old_line is not None
            self.writebacks_out += 1
            self._send(now, Kind.WRITEBACK, old_line, None)
        return way

    def _fetch(self, now: int, request: Request, way: Way) -> None:
        self.fetches += 1
        self.busy_mshrs += 1
        way.targets = [] if request.answer is None else [request.answer]
        way.fetch_tick = now + self.spec.hit_cycles * self.period_ticks
        assert way.line is not None
        self._send(now, Kind.READ, way.line, lambda tick, supplier: self._fill(tick, supplier, way))

    def _fill(self, now: int, supplier: int, way: Way) -> None:
        """Phase 0: the line is here, from `supplier`; so it is for everyone who waits for it."""
        self.busy_mshrs -= 1
        self.fetch_ticks += now - way.fetch_tick
        way.is_coming = False
        for answer in way.targets:
            answer(now, supplier)

    def _send(self, now: int, kind: Kind, line: int, answer: Answer | None) -> None:
        request = Request(kind, line * self.spec.line_bytes, self.spec.line_bytes, answer)
        self.sent += 1
        tick = now + self.spec.hit_cycles * self.period_ticks
        call(at(self.env, tick, Phase.ARRIVE, self.sender), self._deliver, request)

    def _deliver(self, request: Request) -> None:
        self.sent -= 1
        self.parent.arrive(request)


def _victim(ways: list[Way]) -> Way | None:
    """The lowest-numbered invalid way, else the least recently used that is not on its way, else None."""
    invalid = [way for way in ways if way.line is None]
    present = [way for way in ways if way.line is not None and not way.is_coming]
    if invalid:
        return invalid[0]
    return min(present, key=lambda way: way.last_use, default=None)
