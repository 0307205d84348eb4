"""A bounded queue, to be believed: a deque that refuses when it is full."""

from __future__ import annotations

from collections import deque
from typing import Any

from archsim.model.fifo.spec import FifoSpec
from archsim.model.reference import Registered, Stays


class Fifo:
    """At most `num_entries` items, first in, first out."""

    def __init__(self, spec: FifoSpec):
        self.spec = spec
        self.items: deque[Any] = deque()

    def is_full(self) -> bool:
        return len(self.items) >= self.spec.num_entries

    def is_empty(self) -> bool:
        return not self.items

    def push(self, item: Any) -> None:
        assert not self.is_full()
        self.items.append(item)

    def pop(self) -> Any:
        return self.items.popleft()


class Pipe:
    """A fifo between two units, as two counts; what one of them does now the other sees in the next cycle."""

    def __init__(self, spec: FifoSpec):
        self.spec = spec
        self.put_in, self.taken = Registered(), Registered()
        self.stays = Stays()  # of items
        self.peak_items = 0

    def put(self, now: int, num_bytes: int) -> bool:
        """Whether the item had room."""
        held = self.put_in.count - self.taken.seen(now)
        if held >= self.spec.num_entries:
            return False
        self.put_in.add(now, 1)
        self.stays.come(now, 1)
        self.peak_items = max(self.peak_items, held + 1)
        return True

    def has_item(self, now: int) -> bool:
        return self.put_in.seen(now) > self.taken.count

    def coming(self, now: int) -> None:
        """Nothing is on its way in the memory."""

    def take(self, now: int) -> None:
        self.taken.add(now, 1)
        self.stays.leave(now)
