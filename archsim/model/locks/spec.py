"""A table of on-chip locks: what it is."""

from typing import NamedTuple


class LocksSpec(NamedTuple):
    """Lock numbers 0 ... num_locks - 1, each free or held by one thread, granted in the order of asking."""

    num_locks: int
    is_ideal: bool = False  # every LOCK is granted at once, whoever else has it: what locks cost at least
