"""What stalled cycles waited for, cause by cause, as named statistics: the same for cores and for units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.model.causes import AtCache, AtDram, first_cause
from archsim.run.measure import Measure, measured, percent
from archsim.run.result import Statistic


class StallView(NamedTuple):
    """One level of the memory system: the caches of one name, or the DRAM."""

    counts: np.ndarray  # [causes] stalled cycles by their number
    cycles: int  # all that there were
    members: Sequence[int]  # levels of that name
    causes: type[IntEnum]  # what there is to wait for

    def cycles_of(self, cause: int) -> int:
        """Cycles stalled for one cause."""
        return int(sum(self.counts[first_cause(level) + cause] for level in self.members))

    def share(self, cause: int) -> float:
        """The same in per cent."""
        return percent(self.cycles_of(cause), self.cycles)


LEVELS = [
    Measure(
        "stall.{level}_percent",
        "%",
        "Cycles stalled while the request that was waited for was at {level}: the sum of its causes.",
        lambda view: percent(sum(view.cycles_of(cause) for cause in view.causes), view.cycles),
    ),
]

_AT_CACHE = {
    AtCache.LOOKUP: "Of those: while {level} looked it up, until the answer or until it reached the next level.",
    AtCache.PORT: "Of those: while {level} looked up others.",
    AtCache.TARGET: "Of those: while the fetch of its line had no free target, or there were several.",
    AtCache.WAY: "Of those: while all ways of the set were on their way.",
    AtCache.MSHR: "Of those: while no MSHR was free.",
    AtCache.WRITE_QUEUE: "Of those: while the write queue was full.",
}
_AT_DRAM = {
    AtDram.QUEUE: "Of those: while other requests were served.",
    AtDram.REFRESH: "Of those: for a refresh.",
    AtDram.ACTIVATION: "Of those: while its row was opened, or another one closed before.",
    AtDram.TURNAROUND: "Of those: while the bus turned from writing to reading, or back.",
    AtDram.BUS: "Of those: from its column command to its data.",
}


def _measure(cause: AtCache | AtDram, definition: str) -> Measure:
    name = f"stall.{{level}}.{cause.name.lower()}_percent"
    return Measure(name, "%", definition, lambda view: view.share(cause))


AT_CACHE = [_measure(cause, definition) for cause, definition in _AT_CACHE.items()]
AT_DRAM = [_measure(cause, definition) for cause, definition in _AT_DRAM.items()]


def stall_statistics(
    prefix: str, levels: Mapping[str, Sequence[int]], counts: np.ndarray, cycles: int
) -> list[Statistic]:
    """Shares of `cycles` by level and cause. `levels`: caches by name, the DRAM last; `counts`: [causes]."""
    found, last = [], [*levels][-1]
    for level, members in levels.items():
        causes: type[IntEnum] = AtDram if level == last else AtCache
        view = StallView(counts, cycles, members, causes)
        found += measured(prefix, [*LEVELS, *(AT_DRAM if level == last else AT_CACHE)], view, level=level)
    return found
