"""`archsim config check|show`."""

from __future__ import annotations

from archsim.cli.run import find_run
from archsim.config import load_run, resolved_yaml
from archsim.errors import ArchsimError, Problem


def check(files: list[str], overrides: list[str]) -> None:
    """Load every file; raises ArchsimError with the problems of all of them."""
    problems: list[Problem] = []
    for file in files:
        try:
            load_run(find_run(file), overrides)
            print(f"{file}: ok")
        except ArchsimError as error:
            problems += error.problems
    if problems:
        raise ArchsimError(problems)


def show(file: str, overrides: list[str]) -> None:
    """Print the resolved configuration."""
    print(resolved_yaml(load_run(find_run(file), overrides)), end="")
