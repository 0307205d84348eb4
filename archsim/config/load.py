"""From a file, or a packaged configuration, to a checked section; and back to text."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from pydantic import BaseModel

from archsim import resources
from archsim.config.components import ComponentFile, is_component
from archsim.config.document import Node, dump, parse
from archsim.config.inheritance import find_file, is_file, load_tree, put, similar_file
from archsim.config.machine import MachineConfig
from archsim.config.run import RunConfig
from archsim.config.scene import MESH_SUFFIXES, SceneConfig
from archsim.config.sweep import SweepConfig
from archsim.config.validation import in_order, node_at, validate
from archsim.config.walkthrough import WalkthroughConfig
from archsim.config.workload import GridConfig, ShadowMapsConfig, VolumesConfig, WorkloadFile
from archsim.errors import ArchsimError, Location, Problem, did_you_mean

# Of a run and of a walkthrough; a path there is short for `{base: PATH}`.
SECTIONS = ("scene", "workload", "machine")
WALKTHROUGH_SECTIONS = ("scene", "shadow_volumes")

Model = TypeVar("Model", bound=BaseModel)


class Loaded(NamedTuple, Generic[Model]):
    """A section and where each of its values is written."""

    config: Model
    origins: dict[str, Location]  # of every dotted path; defaults are not among them

    def origin(self, path: str) -> Location | None:
        """Where the value at a dotted path is written; None for a default."""
        return self.origins.get(path)

    @contextmanager
    def locating(self) -> Iterator[None]:
        """What goes wrong inside and is about one of the values gets the place where that is written."""
        try:
            yield
        except ArchsimError as error:
            error.say_more(self._located)
            raise

    def _located(self, problem: Problem) -> Problem:
        """With the place of the value that the problem is about, or of the innermost section around it."""
        key = problem.key if problem.where is None else None
        while key and key not in self.origins:
            key = key.rpartition(".")[0]
        return problem._replace(where=self.origins[key]) if key else problem


LoadedRun = Loaded[RunConfig]
LoadedSweep = Loaded[SweepConfig]
LoadedWalkthrough = Loaded[WalkthroughConfig]


def load_run(path: str | Path, overrides: Iterable[str] = ()) -> RunConfig:
    """The run that a file describes, `dotted.path=value` overrides applied. Raises ArchsimError."""
    return load_run_with_origins(path, overrides).config


def load_run_with_origins(path: str | Path, overrides: Iterable[str] = ()) -> LoadedRun:
    """As `load_run`, with the place where each value is written."""
    return _loaded(RunConfig, *_with_mesh(load_tree(path, overrides, SECTIONS), ("scene", "mesh")))


def load_machine(path: str | Path, overrides: Iterable[str] = ()) -> MachineConfig:
    """The machine that a file describes. Raises ArchsimError."""
    return load_machine_with_origins(path, overrides).config


def load_machine_with_origins(path: str | Path, overrides: Iterable[str] = ()) -> Loaded[MachineConfig]:
    """As `load_machine`, with the place where each value is written."""
    return _loaded(MachineConfig, load_tree(path, overrides), [])


def load_scene(path: str | Path, overrides: Iterable[str] = ()) -> SceneConfig:
    """The scene that a file describes, the path of its mesh made absolute. Raises ArchsimError."""
    return _checked(SceneConfig, *_with_mesh(load_tree(path, overrides), ("mesh",)))


def load_workload(
    path: str | Path, overrides: Iterable[str] = ()
) -> GridConfig | VolumesConfig | ShadowMapsConfig:
    """The workload that a file describes, of any kind. Raises ArchsimError."""
    return _checked(WorkloadFile, load_tree(path, overrides), []).root


def load_walkthrough(path: str | Path, overrides: Iterable[str] = ()) -> WalkthroughConfig:
    """The walkthrough that a file describes. Raises ArchsimError."""
    return load_walkthrough_with_origins(path, overrides).config


def load_walkthrough_with_origins(path: str | Path, overrides: Iterable[str] = ()) -> LoadedWalkthrough:
    """As `load_walkthrough`, with the place where each value is written."""
    tree = load_tree(path, overrides, WALKTHROUGH_SECTIONS)
    return _loaded(WalkthroughConfig, *_with_mesh(tree, ("scene", "mesh")))


def load_sweep(path: str | Path, overrides: Iterable[str] = ()) -> SweepConfig:
    """The sweep that a file describes. Raises ArchsimError, also if there is no run that it could start from."""
    return load_sweep_with_origins(path, overrides).config


def load_sweep_with_origins(path: str | Path, overrides: Iterable[str] = ()) -> LoadedSweep:
    """As `load_sweep`, with the place where each value is written."""
    tree = load_tree(path, overrides)
    run, reached = node_at(tree, ("run",))
    problems = _run_problems(run) if reached and isinstance(run.value, str) else []
    return _loaded(SweepConfig, tree, problems)


def sweep_of(keys: Mapping[str, object], source: str = "sweep") -> LoadedSweep:
    """The sweep that a mapping of a file's keys describes; `source` names the mapping. Raises ArchsimError."""
    return _loaded(SweepConfig, parse(dump(dict(keys)), lambda mark: Location(source), Path.cwd()), [])


def load_plain(path: Path) -> tuple[Any, dict[str, Location]]:
    """What a file holds, unchecked, and the place where each value is written. Raises ArchsimError."""
    tree = load_tree(path, ())
    return tree.plain(), dict(_origins(tree, ""))


def run_path(name: str, folder: Path) -> str:
    """The run that a sweep's file in this folder starts from: packaged, beside it, or a packaged one's bare name."""
    beside = folder / name
    if is_file(beside) and not find_file(name, Path("/")):
        return str(beside)
    is_bare = "/" not in name and not Path(name).suffix
    return f"runs/{name}.yaml" if is_bare else name


def load_any(path: str | Path, overrides: Iterable[str] = ()) -> BaseModel:
    """What a file describes: a run, the part of one, a sweep or a walkthrough; its keys tell. Raises ArchsimError."""
    tree = load_tree(path, overrides)
    children = tree.value if isinstance(tree.value, dict) else {}
    if "kind" in children and is_component(children["kind"].value):
        return _checked(ComponentFile, tree, []).root
    parts = {
        "components": load_machine,
        "keyframes": load_walkthrough,
        "mesh": load_scene,
        "kind": load_workload,
        "parameters": load_sweep,
    }
    load = next((load for key, load in parts.items() if key in children), load_run)
    return load(path, overrides)


def resolved_yaml(config: BaseModel) -> str:
    """The whole section as text, defaults and bases written out; loading it gives an equal section."""
    return dump(config.model_dump())


def _loaded(model: type[Model], tree: Node, problems: list[Problem]) -> Loaded[Model]:
    """As `_checked`, with the places of the tree's values."""
    return Loaded(_checked(model, tree, problems), dict(_origins(tree, "")))


def _checked(model: type[Model], tree: Node, problems: list[Problem]) -> Model:
    """The section of a tree. Raises ArchsimError with its problems and those found before."""
    section, found = validate(model, tree)
    if section is None or problems:
        raise ArchsimError(in_order([*problems, *found]))
    return section


def _with_mesh(tree: Node, path: tuple[str, ...]) -> tuple[Node, list[Problem]]:
    """The tree with the mesh at a path absolute where it names a file, and what is wrong with its name."""
    node, reached = node_at(tree, path)
    if not reached or not isinstance(node.value, str):
        return tree, []
    name = Path(node.value)
    if not name.suffix and len(name.parts) == 1:
        return tree, _packaged_problems(node.value, node.where)
    if name.suffix.lower() not in MESH_SUFFIXES:
        what = f"'{node.value}' is not a mesh file of a known type ({', '.join(MESH_SUFFIXES)})"
        return tree, [Problem(node.where, what)]

    absolute = Path(os.path.abspath(node.folder / name.expanduser()))
    if not is_file(absolute):
        what = f"no such mesh file: '{node.value}'"
        return tree, [Problem(node.where, what, similar_file(node.value, node.folder))]
    return put(tree, list(path), replace(node, value=str(absolute))), []


def _run_problems(run: Node) -> list[Problem]:
    """That there is no such run."""
    path = run_path(str(run.value), run.folder)
    if find_file(path, Path.cwd()):
        return []
    return [Problem(run.where, f"no such file: '{path}'", similar_file(path, run.folder))]


def _packaged_problems(name: str, where: Location) -> list[Problem]:
    names = resources.mesh_names()
    if name in names:
        return []
    hint = did_you_mean(name, names) or f"packaged meshes are {', '.join(names)}"
    return [Problem(where, f"no packaged mesh is named '{name}'", hint)]


def _origins(node: Node, path: str) -> Iterator[tuple[str, Location]]:
    """Dotted path and place of the node's children, and of theirs."""
    children: Iterable[tuple[object, Node]] = ()
    if isinstance(node.value, dict):
        children = node.value.items()
    elif isinstance(node.value, list):
        children = enumerate(node.value)
    for key, child in children:
        dotted = f"{path}.{key}" if path else str(key)
        yield dotted, child.where
        yield from _origins(child, dotted)
