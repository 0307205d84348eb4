"""Bytes of shadow-volume triangles in the delay stream: vertices lately seen are named instead of stored again."""

from __future__ import annotations

import numpy as np

from archsim.jit import njit

VERTEX_BYTES = 12  # three float32; whether a vertex is a direction is in the control word
CONTROL_BYTES = 2  # a triangle: three places in the history, or new
HISTORY = 16  # vertices


@njit
def stream_bytes(triangles, starts, drawn):
    """int64 [num_triangles]: bytes that each triangle of the volumes takes; the history starts anew with a volume.

    Those before the first of a volume that is drawn take no room: Stage 2 does not need them.
    """
    size = np.zeros(len(triangles), np.int64)
    history = np.empty(HISTORY, np.int64)
    for volume in range(len(starts) - 1):
        history[:] = -1
        oldest = 0
        for index in range(drawn[volume], starts[volume + 1]):
            size[index] = CONTROL_BYTES
            for corner in range(3):
                vertex = triangles[index, corner]
                if not _is_known(history, vertex):
                    size[index] += VERTEX_BYTES
                    history[oldest] = vertex
                    oldest = (oldest + 1) % HISTORY
    return size


@njit
def _is_known(history, vertex):
    for known in history:
        if known == vertex:
            return True
    return False


@njit
def popped_early(sizes, starts, capacity_bytes):
    """int64 [num_volumes]: triangles that must leave the stream before the last of their volume fits into it."""
    early = np.zeros(len(starts) - 1, np.int64)
    for volume in range(len(early)):
        held = 0
        first = starts[volume]
        for index in range(starts[volume], starts[volume + 1]):
            held += sizes[index]
            while held > capacity_bytes and first < index:
                held -= sizes[first]
                first += 1
        early[volume] = first - starts[volume]
    return early
