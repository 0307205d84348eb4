"""Fixed-function stages, to be believed: the source of the cores' tasks, and a unit of a pipeline."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator
from functools import partial
from typing import Any, NamedTuple, Protocol

import simpy

from archsim.model.cache.reference import Answer, Kind
from archsim.model.delay_stream.reference import DelayStream, Transfer
from archsim.model.fifo.reference import Fifo
from archsim.model.pool.reference import Pool
from archsim.model.reference import Phase, at
from archsim.model.unit.spec import Slot, StageSpec, UnitSpec
from archsim.model.waiting import Wait
from archsim.trace.records import Op

Send = Callable[[int, Kind, int, int, Answer, Wait], None]  # (tick, kind, address, bytes, answer, wait)


class Source:
    """Makes one task every `interval_cycles` for the thread that idles longest, else for the fifo."""

    def __init__(
        self, spec: UnitSpec, env: simpy.Environment, period_ticks: int, tasks: list[Any], fifo: Fifo
    ):
        self.spec, self.env, self.period_ticks = spec, env, period_ticks
        self.unmade = deque(tasks)
        self.fifo = fifo
        self.idle: deque[Any] = deque()  # threads, the longest idle one first

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: at every core edge, end of phase 0."""
        tick = ready_tick = 0
        while self.unmade:
            yield at(self.env, tick, Phase.SOURCE)
            if tick >= ready_tick and self.can_make():
                self._make(tick)
                ready_tick = tick + self.spec.interval_cycles * self.period_ticks
            tick += self.period_ticks

    def take(self, thread: Any) -> Any:
        """The task at the head of the fifo; None when there is none: `thread` idles or retires."""
        if not self.fifo.is_empty():
            return self.fifo.pop()
        if self.unmade:
            thread.idle()
            self.idle.append(thread)
        else:
            thread.retire()
        return None

    def can_make(self) -> bool:
        """Whether there is a task to make and a place to put it."""
        return bool(self.unmade) and (bool(self.idle) or not self.fifo.is_full())

    def _make(self, now: int) -> None:
        task = self.unmade.popleft()
        if self.idle:
            self.idle.popleft().hand(now, task)
        else:
            self.fifo.push(task)

        if not self.unmade:
            for thread in self.idle:
                thread.retire()
            self.idle.clear()


_ACCESSES = {Op.LOAD: Kind.READ, Op.STORE: Kind.WRITE, Op.CLEAR: Kind.CLEAR}
_AHEAD = (Op.LOAD, Op.CLEAR)  # accesses of the front


class Channel(Protocol):
    """A fifo or a delay stream, as the units at its ends see it."""

    def put(self, now: int, num_bytes: int) -> bool: ...

    def has_item(self, now: int) -> bool: ...

    def coming(self, now: int) -> Transfer | None: ...

    def take(self, now: int) -> None: ...


class Access(NamedTuple):
    """A line asked for."""

    number: int  # of those that the unit asked for
    operation: Operation
    wait: Wait


class Operation:
    """An operation between front and back."""

    def __init__(self, record: Any, ready_tick: int, line_bytes: int):
        self.op, self.ready_tick = Op(int(record["op"])), ready_tick
        self.address, self.num_bytes = int(record["address"]), int(record["bytes"])
        self.to_send: deque[tuple[int, int]] = deque()  # address and bytes in one line each
        if self.op == Op.CLEAR:
            self.to_send.append((self.address, self.num_bytes))
        elif self.op in _ACCESSES:
            self.to_send.extend(pieces(self.address, self.num_bytes, line_bytes))
        self.unanswered = len(self.to_send)


def pieces(address: int, num_bytes: int, line_bytes: int) -> Iterator[tuple[int, int]]:
    """An access cut at the lines: (address, bytes) of each part."""
    end = address + num_bytes
    while address < end:
        line_end = min((address // line_bytes + 1) * line_bytes, end)
        yield address, line_end - address
        address = line_end


class Stage:
    """A unit of a pipeline: a front that goes through the records, a back that completes operations, in order."""

    def __init__(
        self,
        spec: StageSpec,
        env: simpy.Environment,
        index: int,
        period_ticks: int,
        records: Iterator[Any],
        channels: list[Channel],
        pools: list[Pool],
        send: Send,
    ):
        self.spec, self.env, self.index, self.period_ticks = spec, env, index, period_ticks
        self.records, self.send = records, send
        self.inputs = [channels[number] for number in spec.inputs]
        self.outputs = [channels[number] for number in spec.outputs]
        self.pools = [pools[number] for number in spec.pools]
        self.record = next(records, None)
        self.is_computed = False  # whether the steps before the record's operation were begun
        self.busy_until = 0
        self.began = 0  # tick in which the task began
        self.is_opening = True  # whether the task has only taken items and tokens
        self.loading: Operation | None = None  # the access of which the front has not asked for all lines
        self.in_flight: deque[Operation] = deque()
        self.under_way = 0  # accesses
        self.num_asked = 0
        self.answered: list[Access] = []  # in this cycle
        # All of this operation has to come, or this transfer of a delay stream; None: any access.
        self.held_by: Operation | Transfer | None = None
        self.unexplained: list[
            int
        ] = []  # ticks at which memory held the front back, for what is not known yet

        self.slots: Counter[Slot] = Counter()
        self.waited: Counter[int] = Counter()  # cycles of Slot.MEMORY by cause
        self.counts: Counter[str] = Counter()
        self.last_move = 0  # tick in which something was last done here
        self.slot = Slot.NO_WORK  # of the current cycle

    def is_done(self) -> bool:
        return self.record is None and not self.in_flight and not self.under_way

    def is_stuck(self, now: int) -> bool:
        """Whether nothing was done in this cycle, and nothing will be unless another component does something."""
        is_on_its_way = bool(self.in_flight) and self.in_flight[0].ready_tick > now
        is_waiting = self.last_move < now and self.slot is not Slot.BUSY
        return is_waiting and not is_on_its_way and not self.under_way

    def waits(self) -> Iterator[tuple[Op, int]]:
        """The operations that cannot be done now, of the back and of the front, and their addresses."""
        if self.in_flight and self.in_flight[0].op == Op.EMIT:
            yield Op.EMIT, self.in_flight[0].address
        if self.record is not None and self.record["op"] in (Op.TAKE, Op.ACQUIRE):
            yield Op(int(self.record["op"])), int(self.record["address"])

    def run(self) -> Generator[simpy.Event, None, None]:
        """The process: in every cycle first the back, then the front."""
        tick = 0
        while True:
            yield at(self.env, tick, Phase.ISSUE, self.index)
            self._explain(tick)
            while self.in_flight and self._complete(tick, self.in_flight[0]):
                self.in_flight.popleft()
                self.last_move = tick
            self.slot = self._front(tick)
            self.slots[self.slot] += 1
            if self.slot is Slot.MEMORY:
                self.unexplained.append(tick)
            tick += self.period_ticks

    def _explain(self, now: int) -> None:
        """Charge the cycles in which memory held the front back, if the access has come that ends them."""
        ending = self._ending(now)
        if ending is not None:
            for tick in self.unexplained:
                self.waited[ending.wait.cause_at(tick)] += 1
            self.unexplained = []
        self.answered = []

    def _ending(self, now: int) -> Access | Transfer | None:
        """The first access that came, if any is enough; the last one of the operation that held the front back.

        Or the transfer that the front waited for, in the cycle after it came.
        """
        if isinstance(self.held_by, Transfer):
            return self.held_by if self.held_by.is_over(now) else None
        if self.held_by is None:
            return min(self.answered, key=lambda access: access.number, default=None)
        if self.held_by.unanswered > 0:
            return None
        own = [access for access in self.answered if access.operation is self.held_by]
        return max(own, key=lambda access: access.number, default=None)

    def _front(self, now: int) -> Slot:
        """Go on as far as it can; returns what the front does in this cycle."""
        while self.record is not None:
            if now < self.busy_until:
                return Slot.BUSY
            if not self.is_computed:
                self._compute(now, int(self.record["compute"]))
                continue
            hindered = self._operate(now, self.record)
            if hindered is not None:
                return hindered
            self.record, self.is_computed = next(self.records, None), False
            self.last_move = now
        return Slot.NO_WORK

    def _compute(self, now: int, steps: int) -> None:
        self.is_computed = True
        if steps > 0:
            self.is_opening = False
            self.busy_until = now + -(-steps // self.spec.lanes) * self.period_ticks

    def _operate(self, now: int, record: Any) -> Slot | None:
        """Do the operation of the record, or say why not."""
        op, number = Op(int(record["op"])), int(record["address"])
        if op == Op.END:
            return self._end(now)
        if op == Op.TAKE:
            return self._take(now, self.inputs[number])
        if op == Op.ACQUIRE:
            return self._acquire(now, self.pools[number])

        self.is_opening = False
        if op in _AHEAD:
            return self._ask_ahead(now, record)
        if len(self.in_flight) >= self.spec.in_flight:
            return self._hindrance(now)
        self._join(now, record)
        return None

    def _end(self, now: int) -> Slot | None:
        if now < self.began + self.spec.interval_cycles * self.period_ticks:
            return Slot.BUSY
        self.counts["tasks"] += 1
        self.began, self.is_opening = now, True
        return None

    def _take(self, now: int, channel: Channel) -> Slot | None:
        if not channel.has_item(now):
            self.held_by = channel.coming(now)
            return Slot.NO_WORK if self.held_by is None else Slot.MEMORY
        channel.take(now)
        self._opened(now)
        return None

    def _acquire(self, now: int, pool: Pool) -> Slot | None:
        if not pool.acquire(now):
            return Slot.POOL
        self._opened(now)
        return None

    def _opened(self, now: int) -> None:
        if self.is_opening:
            self.began = now

    def _ask_ahead(self, now: int, record: Any) -> Slot | None:
        if self.loading is None:
            if len(self.in_flight) >= self.spec.in_flight:
                return self._hindrance(now)
            self.loading = self._join(now, record)
        if not self._ask(now, self.loading):
            self.held_by = None
            return Slot.MEMORY
        self.loading = None
        return None

    def _join(self, now: int, record: Any) -> Operation:
        ready_tick = now + self.spec.latency_cycles * self.period_ticks
        operation = Operation(record, ready_tick, self.spec.line_bytes)
        self.in_flight.append(operation)
        return operation

    def _ask(self, now: int, operation: Operation) -> bool:
        """Whether all lines of the operation are asked for."""
        kind, name = _ACCESSES[operation.op], f"{operation.op.name.lower()}s"
        while operation.to_send and self.under_way < self.spec.outstanding:
            address, num_bytes = operation.to_send.popleft()
            self.under_way += 1
            self.counts[name] += 1
            self.counts[f"{name}_bytes"] += num_bytes
            self.num_asked += 1
            access = Access(self.num_asked, operation, Wait())
            self.send(now, kind, address, num_bytes, partial(self._answered, access), access.wait)
        return not operation.to_send

    def _answered(self, access: Access, now: int) -> None:
        self.answered.append(access)
        access.operation.unanswered -= 1
        self.under_way -= 1
        self.last_move = now

    def _complete(self, now: int, operation: Operation) -> bool:
        """Whether the oldest operation in flight completes now."""
        if operation.op in _AHEAD:
            return operation.unanswered == 0
        if now < operation.ready_tick:
            return False
        if operation.op == Op.STORE:
            return self._ask(now, operation)
        if operation.op == Op.EMIT:
            return self.outputs[operation.address].put(now, operation.num_bytes)
        if operation.op == Op.MARK:
            self.outputs[operation.address].mark(now)  # type: ignore[attr-defined]  # checked: a delay stream
        else:
            self.pools[operation.address].release(now)
        return True

    def _hindrance(self, now: int) -> Slot:
        """Why the oldest operation in flight has not completed."""
        oldest = self.in_flight[0]
        self.held_by = oldest if oldest.op in _AHEAD else None
        if oldest.op in _AHEAD:
            return Slot.MEMORY
        if now < oldest.ready_tick:
            return Slot.LATENCY
        if oldest.op == Op.STORE:
            return Slot.MEMORY
        is_delayed = isinstance(self.outputs[oldest.address], DelayStream)
        return Slot.DELAY_STREAM if is_delayed else Slot.OUTPUT
