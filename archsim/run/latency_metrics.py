"""How long requests were under way, as named statistics and as distributions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from archsim.model.latency import shortest
from archsim.run.measure import Measure


def percentile(counts: np.ndarray, share: float) -> int:
    """The shortest latency of the class in which this share of the requests is reached; 0 without requests."""
    reached = np.flatnonzero(np.cumsum(counts) >= share / 100.0 * counts.sum())
    return shortest(int(reached[0])) if counts.sum() > 0 else 0


def _measure(share: int) -> Measure:
    definition = (
        f"Cycles in which {share} % of the requests that reached this level were answered; rounded down, "
        "to at most a quarter of a power of two."
    )
    return Measure(
        f"latency_p{share}_cycles", "cycles", definition, lambda view: percentile(view.latencies, share)
    )


LATENCIES = [_measure(share) for share in (50, 90, 99)]
"""Of a view with `latencies`: requests by class of latency."""


def latencies_of(
    phase: str, levels: Mapping[str, Sequence[int]], counts: np.ndarray
) -> dict[str, np.ndarray]:
    """Requests by class of latency, by `phase.level`. `counts`: [K + 1, classes]."""
    return {f"{phase}.{level}": counts[list(members)].sum(axis=0) for level, members in levels.items()}
