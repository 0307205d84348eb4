"""The access: one line of an address trace, whatever its text format."""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum

import numpy as np


class Kind(IntEnum):
    """What an access does."""

    READ = 0
    WRITE = 1
    FETCH = 2  # of an instruction: read from the same caches as data


ACCESS = np.dtype(
    [
        (
            "cycle",
            np.int64,
        ),  # when it is made, in the clock of whoever takes it; 0 where a format doesn't say
        ("address", np.int64),  # of its first byte
        ("bytes", np.int32),  # at least 1
        ("requester", np.int16),  # number of whoever makes it, from 0
        ("kind", np.int16),  # Kind
    ]
)

Accesses = Iterator[np.ndarray]  # chunks of ACCESS, in the order of the trace
