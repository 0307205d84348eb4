"""`archsim config check|show`."""

from __future__ import annotations

from pathlib import Path

from archsim import resources
from archsim.config import load_any, resolved_yaml
from archsim.errors import ArchsimError, Problem, did_you_mean, fail


def check(files: list[str], overrides: list[str]) -> None:
    """Load every file, a run or a part of one; raises ArchsimError with the problems of all of them."""
    problems: list[Problem] = []
    for file in files:
        try:
            load_any(find_run(file), overrides)
            print(f"{file}: ok")
        except ArchsimError as error:
            problems += error.problems
    if problems:
        raise ArchsimError(problems)


def show(file: str, overrides: list[str]) -> None:
    """Print the resolved configuration."""
    print(resolved_yaml(load_any(find_run(file), overrides)), end="")


def find_run(name: str) -> str:
    """The path of a run configuration: `name` itself if it is a path, else that of the packaged run.

    Paths from the top of the project, such as configs/runs/tiny.yaml, work everywhere.
    """
    if Path(name).is_file():
        return name
    if "/" in name or name.endswith((".yaml", ".yml")):
        packaged = resources.root() / name
        return str(packaged) if packaged.is_file() else name

    path = resources.config("runs", name)
    if not path.is_file():
        names = sorted(file.stem for file in path.parent.glob("*.yaml"))
        hint = did_you_mean(name, names) or f"packaged runs: {', '.join(names)}"
        raise fail(f"no file and no packaged run '{name}'", hint=hint)
    return str(path)
