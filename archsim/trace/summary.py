"""What an address trace holds, in a few numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.trace.accesses import Accesses, Kind

BLOCK_BYTES = 64  # the footprint is counted in blocks of this size


class Summary(NamedTuple):
    """Of a whole trace; everything is 0 for one without accesses."""

    accesses: int
    reads: int
    writes: int
    fetches: int
    bytes: int  # accessed; the same ones count again
    footprint_bytes: int  # of different blocks accessed; of a longer access, its first and its last block
    requesters: int  # different ones
    first_cycle: int
    last_cycle: int
    lowest_address: int
    highest_address: int  # of the last byte accessed


class _Distinct:
    """The different values of a stream. Memory grows with their number, not with the length of the stream."""

    def __init__(self) -> None:
        self._known = np.zeros(0, np.int64)
        self._pending: list[np.ndarray] = []
        self._num_pending = 0

    def add(self, values: np.ndarray) -> None:
        self._pending.append(np.unique(values))
        self._num_pending += len(self._pending[-1])
        if self._num_pending > len(self._known):
            self.merge()

    def merge(self) -> np.ndarray:
        """All different values so far, ascending."""
        self._known = np.unique(np.concatenate([self._known, *self._pending]))
        self._pending, self._num_pending = [], 0
        return self._known


def summarize(chunks: Accesses) -> Summary:
    """Count what the chunks hold."""
    kinds, blocks, requesters = np.zeros(len(Kind), np.int64), _Distinct(), _Distinct()
    num_bytes, spans = 0, []  # per chunk: first and last cycle, lowest and highest address
    for chunk in chunks:
        last = chunk["address"] + (chunk["bytes"] - 1)
        kinds += np.bincount(chunk["kind"], minlength=len(Kind))
        num_bytes += int(chunk["bytes"].sum(dtype=np.int64))
        blocks.add(chunk["address"] // BLOCK_BYTES)
        blocks.add(last // BLOCK_BYTES)
        requesters.add(chunk["requester"])
        cycles = chunk["cycle"][[0, -1]]
        spans.append([*cycles.tolist(), int(chunk["address"].min()), int(last.max())])

    first, last_cycle, lowest, highest = np.array(spans or [[0, 0, 0, 0]], np.int64).T
    reads, writes, fetches = (int(count) for count in kinds)
    return Summary(
        accesses=reads + writes + fetches,
        reads=reads,
        writes=writes,
        fetches=fetches,
        bytes=num_bytes,
        footprint_bytes=len(blocks.merge()) * BLOCK_BYTES,
        requesters=len(requesters.merge()),
        first_cycle=int(first[0]),
        last_cycle=int(last_cycle[-1]),
        lowest_address=int(lowest.min()),
        highest_address=int(highest.max()),
    )
