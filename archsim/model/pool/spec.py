"""A pool of tokens: what it is."""

from typing import NamedTuple


class PoolSpec(NamedTuple):
    """`num_tokens` equal tokens; who finds none waits until one is given back."""

    num_tokens: int
