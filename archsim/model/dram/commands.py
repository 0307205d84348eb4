"""The commands of a channel, as a simulation records them, and what is counted."""

from collections.abc import Callable
from enum import IntEnum

import numpy as np


class Command(IntEnum):
    """What a channel tells its banks."""

    ACT = 0  # open a row
    PRE = 1  # close the row of a bank
    PREA = 2  # close the rows of all banks
    RD = 3
    WR = 4
    REF = 5  # of all banks


# One command. Of RD and WR, `bursts` go out `n_ccd_l` apart; PREA and REF have bank, row and column 0.
COMMAND = np.dtype(
    [(name, np.int64) for name in ("clock", "channel", "command", "bank", "row", "column", "bursts")]
)

CommandSink = Callable[[np.ndarray], None]  # takes COMMAND records, in order of clock; channels in any

# Counters of a channel; machine/README.md says when they count.
DRAM_COUNTERS = (
    "reads",
    "writes",
    "forwarded",
    "forwarded_bytes",
    "row_hits",
    "row_misses",
    "row_conflicts",
    "activates",
    "precharges",
    "refreshes",
    "data_clocks",
    "waited_clocks",
    "read_queue_clocks",
    "read_refresh_clocks",
    "read_activation_clocks",
    "read_turnaround_clocks",
    "read_bus_clocks",
)
