"""The lock table, to be believed: a holder and a line of waiting threads for each lock."""

from __future__ import annotations

from collections import deque
from typing import Any

from archsim.errors import fail
from archsim.model.locks.spec import LocksSpec


class Lock:
    """One lock: who holds it, and who waits since which tick."""

    def __init__(self) -> None:
        self.holder: Any = None
        self.line: deque[tuple[Any, int]] = deque()  # (thread, tick at which it asked)


class Locks:
    """All locks of a machine, shared by its cores."""

    def __init__(self, spec: LocksSpec):
        self.spec = spec
        self.locks = [Lock() for _ in range(spec.num_locks)]
        self.taken = 0
        self.waited = 0
        self.wait_ticks = 0

    def ask(self, now: int, thread: Any, number: int) -> bool:
        """True when `thread` got the lock at once; else it stands at the end of the line."""
        lock = self.locks[number]
        if self.spec.is_ideal:
            self.taken += 1
            return True
        if lock.holder is None:
            lock.holder = thread
            self.taken += 1
            return True
        self.waited += 1
        lock.line.append((thread, now))
        return False

    def release(self, now: int, thread: Any, number: int) -> Any:
        """The thread that gets the lock now, or None."""
        lock = self.locks[number]
        if self.spec.is_ideal:
            return None
        if lock.holder is not thread:
            raise fail(f"{thread} unlocks lock {number}, which it does not hold")
        if not lock.line:
            lock.holder = None
            return None
        lock.holder, asked = lock.line.popleft()
        self.taken += 1
        self.wait_ticks += now - asked
        return lock.holder

    def waiting(self) -> list[tuple[Any, int, Any]]:
        """(thread, lock number, holder) of every thread that stands in a line."""
        return [
            (thread, number, lock.holder) for number, lock in enumerate(self.locks) for thread, _ in lock.line
        ]
