"""How the requests that the compiled machine sees are told in order of their arrival, not of their sending."""

from __future__ import annotations

from typing import Any

import numpy as np

from archsim.machine.watch import SEEN, Levels, Watch, in_order, tell


class Collector:
    """Keeps what was seen until nothing can come before it any more."""

    def __init__(self, levels: Levels, watch: Watch):
        self.levels, self.watch = levels, watch
        self.pending = np.zeros(0, SEEN)

    def collect(self, state: Any, is_over: bool) -> None:
        """Take what was seen since the last time, and tell what is now final."""
        seen = state.cache.seen[: state.cache.num_seen[0]].astype(SEEN)
        state.cache.num_seen[0] = 0
        self.pending = in_order(np.concatenate([self.pending, seen]))
        number = len(self.pending)
        if not is_over:
            played = state.run[0]["cycle"]  # what is still to come arrives no earlier
            number = int(np.searchsorted(self.pending["cycle"], played))
        tell(self.levels, self.watch, self.pending[:number])
        self.pending = self.pending[number:]
