"""A bounded on-chip queue: what it is."""

from typing import NamedTuple


class FifoSpec(NamedTuple):
    """A queue of at most `num_entries` items; a full queue holds its producer back."""

    num_entries: int
