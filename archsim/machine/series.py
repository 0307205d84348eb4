"""What both models tell at regular intervals: counts since the start, before anything happens in the cycle."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from archsim.machine.counters import Counters


class Sample(NamedTuple):
    """Counts before `cycle`. [N] cores or units, [K] caches; the DRAM's are summed over its channels."""

    cycle: int
    busy: np.ndarray  # [N] issue slots of a core in which an instruction was issued; busy cycles of a unit
    stayed: np.ndarray  # [C] of a pipeline: cycles that items or bytes were in each fifo or delay stream
    lookups: np.ndarray  # [K] accepted, but CLEARs
    hits: np.ndarray  # [K]
    data_clocks: int  # memory clocks in which data buses carry data, counted at the column command
    row_hits: int  # requests whose row was open when first considered
    classified: int  # requests first considered
    waited_clocks: int  # memory clocks from arrival to column command, of the requests that have had that


class Sampling(NamedTuple):
    """Who is told, and how often."""

    interval_cycles: int
    take: Callable[[Sample], None]


def sample_of(cycle: int, counters: Counters) -> Sample:
    """The sample that counters are."""
    return Sample(
        cycle=cycle,
        busy=counters.useful,
        stayed=np.zeros(0, np.int64),
        lookups=counters.cache_hits + counters.cache_merges + counters.cache_misses,
        hits=counters.cache_hits,
        data_clocks=int(counters.dram_data_clocks.sum()),
        row_hits=int(counters.dram_row_hits.sum()),
        classified=int(
            (counters.dram_row_hits + counters.dram_row_misses + counters.dram_row_conflicts).sum()
        ),
        waited_clocks=int(counters.dram_waited_clocks.sum()),
    )
