"""A run: from a checked configuration to a result."""

from __future__ import annotations

from archsim.config import RunConfig
from archsim.run.progress import Progress, silent
from archsim.run.result import Result

__all__ = ["simulate"]


def simulate(config: RunConfig, progress: Progress = silent) -> Result:
    """Run one workload as its RunConfig says. Raises ArchsimError for input that cannot be used."""
    from archsim.run.kinds import kind_of

    return kind_of(config).simulate(config, progress)
