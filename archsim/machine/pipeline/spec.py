"""A machine of fixed-function stages: the specs of its components, in plain integers."""

from __future__ import annotations

from typing import NamedTuple

from archsim.model.cache.spec import CacheSpec
from archsim.model.delay_stream.spec import DelayStreamSpec
from archsim.model.dram.spec import DramSpec
from archsim.model.fifo.spec import FifoSpec
from archsim.model.pool.spec import PoolSpec
from archsim.model.unit.spec import StageSpec


class PipelineSpec(NamedTuple):
    """A graph of units over a tree of caches over a DRAM.

    Channels are numbered, fifos first, then delay streams; each is an output of one unit and an input of one. Caches
    are numbered so that a child's index is smaller than its parent's.
    """

    period_ticks: int  # ticks of a cycle of all units, channels, pools and caches
    units: tuple[StageSpec, ...]
    fifos: tuple[FifoSpec, ...]
    delay_streams: tuple[DelayStreamSpec, ...]
    pools: tuple[PoolSpec, ...]
    caches: tuple[CacheSpec, ...]
    dram: DramSpec

    @property
    def num_channels(self) -> int:
        return len(self.fifos) + len(self.delay_streams)

    def capacity(self, channel: int) -> int:
        """Items that fit into a fifo, bytes that fit into a delay stream."""
        if channel < len(self.fifos):
            return self.fifos[channel].num_entries
        return self.delay_streams[channel - len(self.fifos)].ring_bytes
