"""What both models of a pipeline return: every counter once, in plain integer arrays, so that equality means equal."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.machine.counters import Counters


class PipelineCounters(NamedTuple):
    """Counters of one run. [U] units, [C] channels (fifos, then delay streams), [D] delay streams, [P] pools."""

    cycles: int  # until nothing was left to do for any unit
    unit_slots: np.ndarray  # [U, Slot] cycles by what the front did
    unit_waits: np.ndarray  # [U, causes] cycles of Slot.MEMORY by what was waited for (model/causes.py)
    unit_tasks: np.ndarray  # [U] tasks ended
    unit_loads: np.ndarray  # [U] lines asked for by LOADs
    unit_stores: np.ndarray  # [U] lines asked for by STOREs
    unit_clears: np.ndarray  # [U] CLEARs asked for
    unit_load_bytes: np.ndarray  # [U] bytes that the LOADs named
    unit_store_bytes: np.ndarray  # [U] bytes that the STOREs named
    channel_put: np.ndarray  # [C] items emitted into the channel
    channel_taken: np.ndarray  # [C] items taken from it
    channel_peak: np.ndarray  # [C] most items (fifo) or bytes (delay stream) held at once
    channel_stayed: (
        np.ndarray
    )  # [C] cycles that items (fifo) or bytes (delay stream) were in it, summed over them
    stream_bytes: np.ndarray  # [D] bytes emitted into the delay stream
    stream_writes: np.ndarray  # [D] requests that wrote them to the DRAM
    stream_reads: np.ndarray  # [D] requests that read them back
    stream_marks: np.ndarray  # [D] MARKs
    stream_early: np.ndarray  # [D] items released by overflow, not by a MARK
    pool_acquired: np.ndarray  # [P] tokens taken
    pool_released: np.ndarray  # [P] tokens given back
    pool_peak: np.ndarray  # [P] most tokens held at once
    memory: Counters  # of the caches and the DRAM; without cores
