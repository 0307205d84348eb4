"""A group of identical multithreaded cores: what they are."""

from enum import IntEnum
from typing import NamedTuple


class TaskOrder(IntEnum):
    """Which thread runs which task."""

    FIRST_FREE = 0  # in order, each to the first thread that asks
    INTERLEAVED = 1  # thread t of T runs tasks t, t + T, t + 2T, ... of the stream


class CoreSpec(NamedTuple):
    """`num_cores` cores with `num_threads` threads each. Thread t of core c has the number c * num_threads + t."""

    num_cores: int
    num_threads: int
    period_ticks: int  # ticks of a core cycle
    task_order: int  # TaskOrder
