"""`archsim config check|show|explain|schema`."""

from __future__ import annotations

import json
from pathlib import Path

from archsim import resources
from archsim.config import load_any, load_run_with_origins, resolved_yaml
from archsim.config.documentation import editor_schema
from archsim.config.explain import explain
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


def print_explained(key: str, file: str, overrides: list[str]) -> None:
    """Print what is known of a key of a run."""
    found = explain(load_run_with_origins(find_run(file), overrides), key)
    print(found.path)
    for head, text in (
        ("value", found.value),
        ("meaning", found.meaning),
        ("unit", found.unit or "-"),
        ("accepted", found.accepted),
        ("default", found.default),
        ("set by", found.where or "the default"),
    ):
        print(f"  {head:<9} {text}")


def print_schema(part: str) -> None:
    """Print the JSON Schema of a run's file or of a part's."""
    print(json.dumps(editor_schema(part), indent=1))


def find_run(name: str) -> str:
    """The path of a run configuration, as `find_config` does it; of the folder of a finished run, what it was."""
    kept = Path(name) / "config.yaml"
    is_packaged = "/" not in name and resources.config("runs", name).is_file()
    return str(kept) if kept.is_file() and not is_packaged else find_config("runs", name)


def find_config(kind: str, name: str) -> str:
    """The path of a configuration: `name` itself if it is a path, else that of the packaged one in `configs/KIND`.

    Paths from the top of the project, such as configs/runs/tiny.yaml, work everywhere.
    """
    if Path(name).is_file():
        return name
    if "/" in name or name.endswith((".yaml", ".yml")):
        packaged = resources.root() / name
        return str(packaged) if packaged.is_file() else name

    path = resources.config(kind, name)
    if not path.is_file():
        names = sorted(file.stem for file in path.parent.glob("*.yaml"))
        hint = did_you_mean(name, names) or f"packaged {kind}: {', '.join(names)}"
        raise fail(f"no file and no packaged {kind.removesuffix('s')} '{name}'", hint=hint)
    return str(path)
