"""Recorded DRAM commands as a text file: one command a line, in order of clock."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

import numpy as np

from archsim.errors import Location, fail
from archsim.model.dram.commands import COMMAND, Command
from archsim.model.dram.spec import DramSpec

HEADER = "clock,channel,command,bank,row,column"

# How a command is written; banks closed and refreshed together are not named.
_LINES = {
    Command.ACT: "{clock},{channel},ACT,{bank},{row},",
    Command.PRE: "{clock},{channel},PRE,{bank},,",
    Command.PREA: "{clock},{channel},PREA,,,",
    Command.RD: "{clock},{channel},RD,{bank},{row},{column}",
    Command.WR: "{clock},{channel},WR,{bank},{row},{column}",
    Command.REF: "{clock},{channel},REF,,,",
}


class CommandWriter:
    """Writes what a simulation records; bursts of a request, which are recorded together, each at their own clock."""

    def __init__(self, spec: DramSpec, stream: TextIO):
        self.spec, self.stream = spec, stream
        self.early = np.zeros(0, COMMAND)  # bursts of clocks that are not yet recorded
        stream.write(HEADER + "\n")

    def __call__(self, commands: np.ndarray) -> None:
        """Take COMMAND records, in order of clock."""
        if len(commands) > 0:
            waiting = np.concatenate([self.early, self._single_bursts(commands)])
            is_early = waiting["clock"] >= commands["clock"].max()
            self.early = waiting[is_early]
            self._write(waiting[~is_early])

    def finish(self) -> None:
        """Write what is left."""
        self._write(self.early)
        self.early = self.early[:0]

    def _single_bursts(self, commands: np.ndarray) -> np.ndarray:
        """One command for each burst; columns in beats."""
        bursts = np.maximum(commands["bursts"], 1)
        single = np.repeat(commands, bursts)
        burst = np.arange(len(single)) - np.repeat(np.cumsum(bursts) - bursts, bursts)
        single["clock"] += burst * self.spec.timing.n_ccd_l
        single["column"] = (single["column"] + burst) * self.spec.burst_beats
        return single

    def _write(self, commands: np.ndarray) -> None:
        ordered = commands[np.lexsort((commands["channel"], commands["clock"]))]
        names = COMMAND.names or ()
        rows = (dict(zip(names, each, strict=True)) for each in ordered.tolist())
        self.stream.writelines(_LINES[row["command"]].format(**row) + "\n" for row in rows)


@contextmanager
def written_commands(spec: DramSpec, path: Path) -> Iterator[CommandWriter]:
    """A sink that writes a file."""
    try:
        with path.open("w", encoding="ascii", newline="\n") as stream:
            writer = CommandWriter(spec, stream)
            yield writer
            writer.finish()
    except OSError as error:
        raise fail(f"cannot be written: {error.strerror or error}", Location(str(path))) from None
