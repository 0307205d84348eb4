"""Telling the requests that reach one level of a machine: caches, or the DRAM."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from archsim.trace.accesses import ACCESS, Kind

SEEN = np.dtype([(name, np.int64) for name in ("cycle", "address", "bytes", "requester", "is_write")])


class Watch(NamedTuple):
    """What a simulation is asked to tell: requests in order of their arrival.

    Cycles are core cycles at caches, memory clocks at the DRAM. A request is made by a thread (in a pipeline by a
    unit, or a delay stream behind them), or by the cache of that index; those of one cycle are told in that order.
    """

    places: tuple[int, ...]  # indices of caches, or the number of caches for the DRAM alone
    tell: Callable[[np.ndarray], None]  # takes ACCESS records


class Levels(NamedTuple):
    """What is to be known of a machine of which requests are told."""

    num_caches: int
    period_ticks: int  # of a core cycle
    dram_period_ticks: int  # of a memory clock


def in_order(seen: np.ndarray) -> np.ndarray:
    """SEEN records by arrival, then by who makes them."""
    return seen[np.lexsort((seen["requester"], seen["cycle"]))]


def tell(levels: Levels, watch: Watch, seen: np.ndarray) -> None:
    """Tell SEEN records, whose cycles are core cycles."""
    if len(seen) == 0:
        return
    accesses = np.zeros(len(seen), ACCESS)
    accesses["cycle"] = seen["cycle"]
    if levels.num_caches in watch.places:
        accesses["cycle"] = -(-seen["cycle"] * levels.period_ticks // levels.dram_period_ticks)
    for name in ("address", "bytes", "requester"):
        accesses[name] = seen[name]
    accesses["kind"] = np.where(seen["is_write"] != 0, Kind.WRITE, Kind.READ)
    watch.tell(accesses)
