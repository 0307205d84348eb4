"""Pools of tokens, compiled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.model.compiled import add_now, inlined_step, new_counts, record, seen, step
from archsim.model.pool.spec import PoolSpec

POOL = record("num_tokens", "acquired", "peak")


class PoolsState(NamedTuple):
    """P pools."""

    pools: np.ndarray  # POOL [P]
    released: np.ndarray  # REGISTERED [P]


def new_pools(specs: Sequence[PoolSpec]) -> PoolsState:
    """All tokens free."""
    pools = np.zeros(len(specs), POOL)
    pools["num_tokens"] = [spec.num_tokens for spec in specs]
    return PoolsState(pools, new_counts(len(specs)))


@step
def acquire(state, cycle, number):
    """Whether there is a token to take in `cycle`; then it is taken."""
    pool = state.pools[number]
    held = pool["acquired"] - seen(state.released, number, cycle)
    if held >= pool["num_tokens"]:
        return False
    pool["acquired"] += 1
    pool["peak"] = max(pool["peak"], held + 1)
    return True


@inlined_step
def release(state, cycle, number):
    """A token comes back in `cycle`."""
    add_now(state.released, number, cycle, 1)
