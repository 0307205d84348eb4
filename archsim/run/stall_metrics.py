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
    AtCache.LOOKUP: "Cycles stalled for a lookup of {level}, to the answer or to the arrival at the next level.",
    AtCache.PORT: "Cycles stalled while {level} looked up other requests.",
    AtCache.TARGET: "Cycles stalled in {level} for a free target of a fetch, or for the end of one of several.",
    AtCache.WAY: "Cycles stalled in {level} while all ways of a set were on their way.",
    AtCache.MSHR: "Cycles stalled in {level} while no MSHR was free.",
    AtCache.WRITE_QUEUE: "Cycles stalled in {level} while its write queue was full.",
}
_AT_DRAM = {
    AtDram.QUEUE: "Cycles stalled in {level} while other requests were served.",
    AtDram.REFRESH: "Cycles stalled in {level} for a refresh.",
    AtDram.ACTIVATION: "Cycles stalled in {level} for a row to be opened, and another one closed before.",
    AtDram.TURNAROUND: "Cycles stalled in {level} for the bus to turn from writing to reading, or back.",
    AtDram.BUS: "Cycles stalled in {level} from a column command to its data.",
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
    found: list[Statistic] = []
    last = max(levels, key=lambda level: max(levels[level]), default="")
    for level, members in levels.items():
        causes: type[IntEnum] = AtDram if level == last else AtCache
        view = StallView(counts, cycles, members, causes)
        found += measured(prefix, [*LEVELS, *(AT_DRAM if level == last else AT_CACHE)], view, level=level)
    return found
