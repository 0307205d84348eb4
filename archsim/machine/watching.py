"""What a compiled machine keeps for others, and how they are told: requests in order of arrival, DRAM commands."""

from __future__ import annotations

from typing import Any

import numpy as np

from archsim.machine.watch import SEEN, Levels, Watch, in_order, tell
from archsim.model.dram.commands import CommandSink
from archsim.model.dram.compiled import recording, take_log


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


class Teller:
    """Tells a sink the DRAM's commands and a watch the requests, whichever there is."""

    def __init__(self, levels: Levels, sink: CommandSink | None, watch: Watch | None):
        self.sink = sink
        self.collector = None if watch is None else Collector(levels, watch)

    def ready(self, state: Any) -> Any:
        """The state with room for what it is to keep."""
        return state if self.sink is None else state._replace(dram=recording(state.dram))

    def collect(self, state: Any, is_over: bool) -> None:
        """Tell what the state has kept since the last time and is now final."""
        if self.collector is not None:
            self.collector.collect(state, is_over)
        if self.sink is not None:
            take_log(state.dram, self.sink)
