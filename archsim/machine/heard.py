"""Who is told what while a machine plays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from archsim.machine.series import Sampling
from archsim.machine.watch import Watch
from archsim.model.dram.commands import CommandSink


class Heard(NamedTuple):
    """What one playing of a machine is asked to tell."""

    sink: CommandSink | None = None  # takes the commands of the DRAM
    watch: Watch | None = None  # takes the requests that reach a level
    sampling: Sampling | None = None  # takes counts at intervals, and at the end
    observe: Callable[[Any], None] | None = None  # is shown the reference model before anything happens


NOTHING = Heard()
