"""A bounded queue, to be believed: a deque that refuses when it is full."""

from __future__ import annotations

from collections import deque
from typing import Any

from archsim.model.fifo.spec import FifoSpec


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
