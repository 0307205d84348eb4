"""A pool, to be believed: two counts, of tokens taken and of tokens given back."""

from __future__ import annotations

from archsim.model.pool.spec import PoolSpec
from archsim.model.reference import Registered


class Pool:
    """Tokens that one unit acquires and another one releases; a token released now is free in the next cycle."""

    def __init__(self, spec: PoolSpec):
        self.spec = spec
        self.acquired = 0
        self.released = Registered()
        self.peak = 0

    def acquire(self, now: int) -> bool:
        """Whether there was a token to take."""
        held = self.acquired - self.released.seen(now)
        if held >= self.spec.num_tokens:
            return False
        self.acquired += 1
        self.peak = max(self.peak, held + 1)
        return True

    def release(self, now: int) -> None:
        self.released.add(now, 1)
