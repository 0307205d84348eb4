"""What a DRAM alone is fed with, and what comes out.

The stream's requests enter in order: in memory clock m, before the commands of m, as long as the next one's arrival is
no later than m and its channel's queue has room among what the scheduler sees. With all arrivals 0 this is a closed
loop, limited by the queues alone. The run ends with the clock in which all requests have been served and the last
read is answered. Requests are `request_bytes` long, aligned to that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.model.dram.spec import DramSpec

LONGEST_LATENCY = 1 << 14  # clocks; the last class of the distribution holds all that are longer


class Requests(NamedTuple):
    """N requests of a stream."""

    addresses: np.ndarray  # [N] int64 bytes
    is_write: np.ndarray  # [N] bool
    arrivals: np.ndarray  # [N] int64 memory clocks, never falling


class DramRun(NamedTuple):
    """A stream that was served. [H] channels; time in memory clocks."""

    clocks: int  # until the last data moved
    counters: dict[str, np.ndarray]  # [H] by name, see DRAM_COUNTERS
    latencies: (
        np.ndarray
    )  # [LONGEST_LATENCY + 1] reads by clocks from entering the queue to the last beat, rounded up
    latency_sum: int  # of all reads
    latency_max: int
    wait_sum: int  # clocks from arrival to entering, of all requests

    @property
    def num_requests(self) -> int:
        return sum(int(self.counters[name].sum()) for name in ("reads", "writes", "forwarded"))

    @property
    def mean_latency(self) -> float:
        """Clocks of a read; 0 without reads."""
        num_reads = int(self.latencies.sum())
        return self.latency_sum / num_reads if num_reads else 0.0


def bursts_of(spec: DramSpec, request_bytes: int) -> int:
    """Bursts of a request. ArchsimError unless that is a whole number."""
    burst_bytes = spec.burst_beats * spec.beat_bytes
    if request_bytes <= 0 or request_bytes % burst_bytes:
        raise fail(f"a request must be a whole number of bursts of {burst_bytes} bytes, not {request_bytes}")
    return request_bytes // burst_bytes


def check(requests: Requests, previous_arrival: int) -> None:
    """ArchsimError for requests that are out of order or have no place."""
    arrivals = requests.arrivals
    if len(arrivals) and (arrivals[0] < previous_arrival or np.any(np.diff(arrivals) < 0)):
        raise fail("requests must be in order of their arrival")
    if len(arrivals) and int(requests.addresses.min()) < 0:
        raise fail("requests must have addresses of at least 0")
