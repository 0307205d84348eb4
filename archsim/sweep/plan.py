"""The points of a sweep with what identifies them: what a point depends on is what it is called."""

from __future__ import annotations

import hashlib
import json
from functools import cache
from typing import Any, NamedTuple

from archsim import resources
from archsim.config import RunConfig, SceneConfig, load_run
from archsim.config.sweep import SweepConfig
from archsim.errors import ArchsimError, fail
from archsim.jit import code_digest
from archsim.run.kinds import kind_of
from archsim.run.rendering import Functional
from archsim.scene.scene import digest, load_scene
from archsim.sweep.expand import Parameters, command, expand, overrides

_WITHOUT_EFFECT = frozenset(
    {"report", "reproduce", "cli", "sweep", "api.py", "__init__.py"}
)  # on a run's result


class Point(NamedTuple):
    """One run of a sweep."""

    parameters: Parameters
    command: str  # that repeats it on its own
    config: RunConfig | None  # None: the values do not make a run
    digest: str  # of all that its result depends on
    functional_digest: str | None  # of all that its picture and work depend on; None: there is no config
    from_machine: dict[str, Any]  # what its picture and work take from the machine, by name
    error: str | None  # why there is no config


def make_plan(sweep: SweepConfig, run: str) -> list[Point]:
    """All points; those whose values do not make a run carry the reason. `run` is the path of the run's file."""
    load_run(run)  # what is wrong with the run itself is said at once
    return [_point(run, {**sweep.set, **parameters}) for parameters in expand(sweep)]


def shard(points: list[Point], index: int, count: int) -> list[Point]:
    """Part `index` of `count`, counted from 1; points that share their work stay together as far as can be."""
    if not 1 <= index <= count:
        raise fail(f"a shard is written I/N with 1 <= I <= N, not {index}/{count}")
    together = sorted(points, key=lambda point: point.functional_digest or "")
    return together[len(points) * (index - 1) // count : len(points) * index // count]


def _point(run: str, parameters: Parameters) -> Point:
    repeat = command(run, parameters)
    try:
        config = load_run(run, overrides(parameters))
        functional = kind_of(config).functional(config)
        own, shared = _digests(config, functional)
    except ArchsimError as error:
        return Point(parameters, repeat, None, _digest({"command": repeat}), None, {}, str(error))
    return Point(parameters, repeat, config, own, shared, functional.from_machine(), None)


def _digests(config: RunConfig, functional: Functional) -> tuple[str, str]:
    """Of all that the result depends on, and of all that picture and work depend on."""
    whole = config.model_dump(mode="json", exclude={"name"})
    scene = config.scene and _scene_digest(config.scene.model_dump_json())
    made_of = {"code": _code(), "scene": scene}
    return _digest({**made_of, "config": whole}), _digest({**made_of, **functional.described()})


@cache
def _scene_digest(scene: str) -> str:
    """Of what a scene's section, as JSON, describes; once for all points that share it."""
    return digest(load_scene(SceneConfig.model_validate_json(scene)))


@cache
def _code() -> str:
    """Of the source that computes results: the package's and the kernels'."""
    kernels = sorted((resources.root() / "kernels").glob("*.s"))
    texts = [code_digest(_WITHOUT_EFFECT), *(path.name + path.read_text() for path in kernels)]
    return _digest(texts)


def _digest(tree: Any) -> str:
    return hashlib.sha256(json.dumps(tree, sort_keys=True, default=str).encode()).hexdigest()[:20]
