"""Memory as a kernel sees it: a flat float32 array, indexed by byte address // 4, and two windows into it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import Problem

WORD_BYTES = 4
LARGEST_ACCESS_BYTES = 16


class Window(NamedTuple):
    """What a base register holds and guards. The hardware ORs the index into the base, so both are aligned.

    The last element of the window is the guard element: accesses with an index that is NaN, negative or
    outside of the window go there.
    """

    base: int  # byte address, a multiple of size
    size: int  # bytes, a power of two

    def num_elements(self, element_bytes: int) -> int:
        """Elements of that size in the window, the guard element included."""
        return self.size // element_bytes

    def guard(self, element_bytes: int) -> int:
        """Byte address of the guard element."""
        return self.base + self.size - element_bytes


def new_memory(num_bytes: int) -> np.ndarray:
    """Zeroed memory: float32 [num_bytes / 4]."""
    return np.zeros(num_bytes // WORD_BYTES, np.float32)


def window_problems(windows: tuple[Window, Window]) -> list[Problem]:
    """What keeps these windows from being loaded into B0 and B1."""
    problems = []
    for k, window in enumerate(windows):
        if window.size < LARGEST_ACCESS_BYTES or window.size & (window.size - 1):
            what = f"window B{k} has {window.size} bytes, not a power of two from {LARGEST_ACCESS_BYTES} on"
            problems.append(Problem(None, what))
        elif window.base < 0 or window.base % window.size:
            what = f"window B{k} starts at {window.base}, not a multiple of its size {window.size}"
            problems.append(Problem(None, what))
    return problems
