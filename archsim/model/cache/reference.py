"""A cache, to be believed: a process that looks up arrived requests at every core edge."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator
from enum import Enum
from functools import partial
from typing import NamedTuple, Protocol

import simpy

from archsim.model.cache.reference_clear import ClearBits
from archsim.model.cache.reference_set import Answer, Fetch, Set, Way
from archsim.model.cache.spec import Arbiter, CacheSpec, VictimOrder, WritePolicy
from archsim.model.causes import AtCache, first_cause
from archsim.model.latency import class_of
from archsim.model.reference import Phase, at, call
from archsim.model.waiting import Wait

# Attributes of a cache that count; machine/counters.py says what.
CACHE_COUNTS = (
    *("hits", "merges", "misses", "clear_fills", "fetches", "writebacks_out", "writethroughs_out"),
    *("fetched_bytes", "written_bytes", "blocked", "fetch_ticks"),
)


class Kind(Enum):
    READ = "read"  # LOAD, or a child's fetch
    WRITE = "write"  # STORE
    WRITEBACK = "write-back"  # a child's dirty victim, or a write that it passes on
    CLEAR = "clear"  # memory is cleared


class Request(NamedTuple):
    """What a cache or a channel is asked, of one line. A write-back wants no answer."""

    kind: Kind
    address: int
    num_bytes: int
    answer: Answer | None
    wait: Wait  # what becomes known of where it waits
    sender: int = 0  # number of the core or cache that asks
    taken: Callable[[], None] | None = None  # called when the request is accepted


class NextLevel(Protocol):
    """A cache's parent, or the DRAM."""

    def cut(self, address: int, num_bytes: int) -> list[tuple[int, int]]: ...  # as it wants to be asked

    def arrive(self, request: Request) -> None: ...


def timed(answer: Answer | None, latencies: Counter[int], arrival: int, period_ticks: int) -> Answer | None:
    """The answer of a request that is here now, which counts in the class of its latency."""

    def answered(tick: int) -> None:
        latencies[class_of((tick - arrival) // period_ticks)] += 1
        assert answer is not None
        answer(tick)

    return None if answer is None else answered


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
        self.sets = [Set(spec) for _ in range(spec.num_sets)]
        self.clear_bits = ClearBits(spec.clear)
        self.input: list[Request] = []
        self.last_sender = -1  # of the last accepted request
        self.busy_mshrs = 0
        self.sent = 0  # requests that have not yet arrived at the next level
        self.waiting_writes = 0  # writes that the next level has not yet accepted
        self.uses = 0  # accepted requests, but CLEARs: the clock of LRU
        self.lack = AtCache.MSHR  # what the last refused request lacked

        self.accepted = dict.fromkeys(Kind, 0)
        self.hits = self.merges = self.misses = self.clear_fills = 0
        self.fetches = self.writebacks_out = self.writethroughs_out = 0
        self.fetched_bytes = self.written_bytes = 0
        self.blocked = 0
        self.fetch_ticks = 0
        self.latencies: Counter[int] = Counter()  # of the requests answered, by class

    def is_quiet(self) -> bool:
        """Nothing waits here and nothing is on its way to or from the next level."""
        return not self.input and not self.busy_mshrs and not self.sent

    def cut(self, address: int, num_bytes: int) -> list[tuple[int, int]]:
        """(address, bytes) of the parts that lie in different lines, in ascending order."""
        line = self.spec.line_bytes
        ends = [*range((address // line + 1) * line, address + num_bytes, line), address + num_bytes]
        return [(start, end - start) for start, end in zip([address, *ends], ends, strict=False)]

    def arrive(self, request: Request) -> None:
        """`request` is here now."""
        answer = timed(request.answer, self.latencies, int(self.env.now), self.period_ticks)
        self.input.append(request._replace(answer=answer))
        request.wait.mark(int(self.env.now), self._cause(AtCache.PORT))

    def _cause(self, what: AtCache) -> int:
        return first_cause(self.index) + what

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: phase 2 of every core edge."""
        tick = 0
        while True:
            yield at(self.env, tick, Phase.LOOKUP, self.index)
            for _ in range(min(self.spec.num_ports, len(self.input))):
                request = self._choose()
                if not self._accept(tick, request):
                    self._block(tick)
                    break
                self.input.remove(request)
                self.last_sender = request.sender
                if request.taken is not None:
                    request.taken()
            tick += self.period_ticks

    def _block(self, now: int) -> None:
        """A request was refused: whoever waits here has waited for what that lacks, and waits for it a cycle more."""
        self.blocked += 1
        for request in self.input:
            request.wait.since_the_first(self._cause(self.lack))
            request.wait.mark(now + self.period_ticks, self._cause(AtCache.PORT))

    def _choose(self) -> Request:
        """The arrived request that is looked up next; `min` takes the first of several."""
        if self.spec.arbiter == Arbiter.FIXED_PRIORITY:
            return min(self.input, key=lambda request: request.sender)
        if self.spec.arbiter == Arbiter.ROUND_ROBIN:
            return min(self.input, key=lambda request: (request.sender <= self.last_sender, request.sender))
        return self.input[0]

    def _accept(self, now: int, request: Request) -> bool:
        """Look up `request`; False when it cannot be accepted now, and nothing has changed."""
        if request.kind is Kind.CLEAR:
            self._clear(now, request)
            return True

        line = request.address // self.spec.line_bytes
        way = self.sets[line % self.spec.num_sets].find(line)
        touched = self._sectors(request)
        missing = touched - way.present if way is not None else touched
        if way is not None and not missing:
            is_accepted = self._hit(now, request, way)
        elif way is not None and missing & way.coming.keys():
            is_accepted = self._merge(now, request, way, missing)
        else:
            is_accepted = self._miss(now, request, way)
        self.accepted[request.kind] += is_accepted
        return is_accepted

    def _sectors(self, request: Request) -> set[int]:
        """Sectors of the line that the request's bytes lie in."""
        first = request.address % self.spec.line_bytes
        last = first + request.num_bytes - 1
        return set(range(first // self.spec.sector_bytes, last // self.spec.sector_bytes + 1))

    def _hit(self, now: int, request: Request, way: Way) -> bool:
        if self._goes_through(request) and not self._has_room():
            return self._refuse(AtCache.WRITE_QUEUE)
        self.hits += 1
        self._use(way)
        self._answer_at_hit_time(now, request)
        self._write(now, request, way)
        return True

    def _merge(self, now: int, request: Request, way: Way, missing: set[int]) -> bool:
        """Wait with the fetch that brings all that is missing."""
        fetches = {id(fetch): fetch for sector, fetch in way.coming.items() if sector in missing}
        fetch = next(iter(fetches.values()))
        if len(fetches) > 1 or not missing <= fetch.sectors:
            return self._refuse(AtCache.TARGET)
        if request.answer is not None and len(fetch.targets) >= self.spec.num_targets:
            return self._refuse(AtCache.TARGET)
        if self._goes_through(request) and not self._has_room():
            return self._refuse(AtCache.WRITE_QUEUE)

        self.merges += 1
        request.wait.accept(now, fetch.wait)
        if request.answer is not None:
            fetch.targets.append(request.answer)
        self._use(way)
        self._write(now, request, way)
        return True

    def _miss(self, now: int, request: Request, way: Way | None) -> bool:
        """Nothing of what is missing is on its way."""
        is_write = request.kind is not Kind.READ
        if is_write and way is None and not self.spec.allocates_writes:
            return self._pass_on(now, request)

        line = request.address // self.spec.line_bytes
        place = way or self.sets[line % self.spec.num_sets].victim(self.uses + 1)
        if place is None:
            return self._refuse(AtCache.WAY)
        victim = [] if place is way else self._dirty_runs(place)
        is_cleared = self._wants_data(request) and self.clear_bits.are_set(*self._span(request))
        fetches = self._wants_data(request) and not is_cleared
        if fetches and self.busy_mshrs >= self.spec.num_mshrs:
            return self._refuse(AtCache.MSHR)
        if (victim or self._goes_through(request)) and not self._has_room():
            return self._refuse(AtCache.WRITE_QUEUE)

        self.misses += 1
        self.clear_fills += is_cleared
        if place is not way:
            place.take(line)
            place.first_use = self.uses + 1
        self._use(place)
        if self.spec.victim_order == VictimOrder.WRITE_BACK_FIRST:
            self._write_back(now, victim)
        if fetches:
            self._fetch(now, request, place)
        else:
            place.present |= self._sectors(request)
            self._answer_at_hit_time(now, request)
        self._write(now, request, place)
        if self.spec.victim_order == VictimOrder.FETCH_FIRST:
            self._write_back(now, victim)
        return True

    def _refuse(self, lack: AtCache) -> bool:
        """The request lacks this: it is not accepted."""
        self.lack = lack
        return False

    def _pass_on(self, now: int, request: Request) -> bool:
        """A write that finds no line goes to the next level as it is."""
        if not self._has_room():
            return self._refuse(AtCache.WRITE_QUEUE)
        self.misses += 1
        self.uses += 1
        self._write_through(now, request)
        self._answer_at_hit_time(now, request)
        return True

    def _use(self, way: Way) -> None:
        """The request that is being accepted uses the line in this way."""
        self.uses += 1
        way.last_use = self.uses
        assert way.line is not None
        self.sets[way.line % self.spec.num_sets].mark(way, self.uses)

    def _wants_data(self, request: Request) -> bool:
        """Whether what is missing has to come: not if all of it is written, or if writes do not allocate."""
        if request.kind is Kind.READ:
            return True
        is_covered = request.num_bytes == len(self._sectors(request)) * self.spec.sector_bytes
        return bool(self.spec.allocates_writes) and not is_covered

    def _goes_through(self, request: Request) -> bool:
        return request.kind is not Kind.READ and self.spec.write_policy == WritePolicy.WRITE_THROUGH

    def _has_room(self) -> bool:
        """Whether one more write may be sent."""
        return self.spec.num_write_entries == 0 or self.waiting_writes < self.spec.num_write_entries

    def _write(self, now: int, request: Request, way: Way) -> None:
        """What a write does to the line in this way or to the next level; nothing for a read."""
        if self._goes_through(request):
            self._write_through(now, request)
        elif request.kind is not Kind.READ:
            way.dirty |= self._sectors(request)

    def flush(self, now: int) -> None:
        """Write all dirty sectors to the next level, set by set, way by way; whether there is room does not matter."""
        for way in (way for each in self.sets for way in each.ways if way.dirty):
            self._write_back(now, self._dirty_runs(way))
            way.dirty = set()

    def _write_through(self, now: int, request: Request) -> None:
        self.writethroughs_out += self._send_write(now, request.address, request.num_bytes)

    def _write_back(self, now: int, runs: list[tuple[int, int]]) -> None:
        for address, num_bytes in runs:
            self.writebacks_out += self._send_write(now, address, num_bytes)

    def _dirty_runs(self, way: Way) -> list[tuple[int, int]]:
        """(address, bytes) of the runs of dirty sectors, the highest address first."""
        size = self.spec.sector_bytes
        runs: list[tuple[int, int]] = []
        for sector in sorted(way.dirty):
            assert way.line is not None
            start = way.line * self.spec.line_bytes + sector * size
            if runs and sum(runs[-1]) == start:
                start = runs.pop()[0]
            runs.append((start, way.line * self.spec.line_bytes + (sector + 1) * size - start))
        return runs[::-1]

    def _span(self, request: Request) -> tuple[int, int]:
        """(address, bytes) of the sectors that the request touches."""
        sectors = self._sectors(request)
        line_start = request.address // self.spec.line_bytes * self.spec.line_bytes
        return line_start + min(sectors) * self.spec.sector_bytes, len(sectors) * self.spec.sector_bytes

    def _fetch(self, now: int, request: Request, way: Way) -> None:
        """Ask the next level for the sectors that the request touches."""
        self.busy_mshrs += 1
        parts = self.parent.cut(*self._span(request))
        fetch = Fetch(now + self.spec.hit_cycles * self.period_ticks, self._sectors(request), len(parts))
        fetch.targets = [] if request.answer is None else [request.answer]
        request.wait.accept(now, fetch.wait)
        fetch.wait.mark(now, self._cause(AtCache.LOOKUP))
        way.coming |= dict.fromkeys(fetch.sectors, fetch)
        for number, (address, num_bytes) in enumerate(parts):
            self.fetches += 1
            self.fetched_bytes += num_bytes
            answer = partial(self._part_is_here, way, fetch, number)
            self._send(now, Request(Kind.READ, address, num_bytes, answer, fetch.parts[number], self.sender))
        fetch.wait.mark(fetch.arrival, fetch.parts[-1])

    def _part_is_here(self, way: Way, fetch: Fetch, number: int, now: int) -> None:
        """Phase 0: a part of a fetch is here; with the last one its sectors are, and so they are for all who wait."""
        self.fetch_ticks += now - fetch.arrival
        fetch.parts_left -= 1
        fetch.answered = max(fetch.answered, (now, number))
        if fetch.parts_left > 0:
            return
        if len(fetch.parts) > 1:
            last_accepted = fetch.parts[-1].marks[-1][0]
            fetch.wait.mark(last_accepted, fetch.parts[fetch.answered[1]])
        self.busy_mshrs -= 1
        way.present |= fetch.sectors
        for sector in fetch.sectors:
            del way.coming[sector]
        for answer in fetch.targets:
            answer(now)

    def _answer_at_hit_time(self, now: int, request: Request) -> None:
        if request.answer is not None:
            request.wait.accept(now, self._cause(AtCache.LOOKUP))
            tick = now + self.spec.hit_cycles * self.period_ticks
            call(at(self.env, tick, Phase.FILL), request.answer, tick)

    def _send_write(self, now: int, address: int, num_bytes: int) -> int:
        """Send a write that wants no answer; the number of requests that it takes."""
        self.clear_bits.reset(address, num_bytes)
        parts = self.parent.cut(address, num_bytes)
        for part_address, part_bytes in parts:
            self.written_bytes += part_bytes
            self.waiting_writes += 1
            request = Request(
                Kind.WRITEBACK, part_address, part_bytes, None, Wait(), self.sender, self._write_is_taken
            )
            self._send(now, request)
        return len(parts)

    def _write_is_taken(self) -> None:
        self.waiting_writes -= 1

    def _send(self, now: int, request: Request) -> None:
        self.sent += 1
        tick = now + self.spec.hit_cycles * self.period_ticks
        call(at(self.env, tick, Phase.ARRIVE, self.sender), self._deliver, request)

    def _deliver(self, request: Request) -> None:
        self.sent -= 1
        self.parent.arrive(request)

    def _clear(self, now: int, request: Request) -> None:
        """Set the bits of the blocks within the memory; lines within them that are not on their way are dropped."""
        start, end = self.clear_bits.set(request.address, request.num_bytes)
        for way in (way for each in self.sets for way in each.ways):
            if way.line is None or way.coming:
                continue
            first = way.line * self.spec.line_bytes
            if start <= first and first + self.spec.line_bytes <= end:
                way.take(None)
        self.accepted[Kind.CLEAR] += 1
        self._answer_at_hit_time(now, request)
