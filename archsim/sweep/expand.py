"""From a sweep's blocks to its points: which values each point sets."""

from __future__ import annotations

import itertools
import json
import random
import re
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from archsim.config.document import parse
from archsim.config.sweep import BlockConfig, RandomConfig, RangeConfig, SweepConfig
from archsim.errors import ArchsimError, Location, fail

MAX_POINTS = 100_000

Parameters = dict[str, Any]  # path as written in the file -> value


def expand(sweep: SweepConfig) -> list[Parameters]:
    """The parameters of every point, each combination once, in the order of the file."""
    points: list[Parameters] = [{}]
    for block in sweep.parameters:
        points = [extended for point in points for extended in _extended(point, block)]
        if len(points) > MAX_POINTS:
            raise fail(f"the sweep '{sweep.name}' has more than {MAX_POINTS:,} points")
    if sweep.seeds > 1:
        points = [{**point, "seed": seed} for point in points for seed in range(sweep.seeds)]
    return list({json.dumps(point, sort_keys=True, default=str): point for point in points}.values())


def overrides(parameters: Mapping[str, Any]) -> list[str]:
    """`dotted.path=value` for `--set`, the braces of paths written out."""
    return [f"{path}={flow(value)}" for key, value in parameters.items() for path in paths(key)]


def paths(key: str) -> list[str]:
    """The dotted paths that `a.{b,c}.d` stands for."""
    parts = re.split(r"\{([^{}]*)\}", key)
    choices = [part.split(",") if index % 2 else [part] for index, part in enumerate(parts)]
    return ["".join(chosen).replace(" ", "") for chosen in itertools.product(*choices)]


def command(run: str, parameters: Mapping[str, Any]) -> str:
    """What repeats a point on its own."""
    words = ["archsim", "run", run]
    for override in overrides(parameters):
        words += ["--set", override]
    return shlex.join(words)


def flow(value: Any) -> str:
    """A value on one line, so that YAML reads it back as it is."""
    if isinstance(value, str) and _reads_back(value):
        return value
    return json.dumps(value, ensure_ascii=False)


def _extended(point: Parameters, block: BlockConfig) -> Iterator[Parameters]:
    """The point with every choice of a block, or as it is where the block does not apply."""
    if block.when is not None and not _holds(block.when, point):
        yield point
        return
    for chosen in _choices(block):
        yield {**point, **chosen}


def _holds(condition: Mapping[str, Any], point: Parameters) -> bool:
    for key, wanted in condition.items():
        accepted = wanted if isinstance(wanted, list | tuple) else [wanted]
        if key not in point:
            raise fail(f"`when` asks for '{key}', which no block before it sets")
        if point[key] not in accepted:
            return False
    return True


def _choices(block: BlockConfig) -> Iterator[Parameters]:
    if block.grid is not None:
        for values in itertools.product(*block.grid.values()):
            yield dict(zip(block.grid, values, strict=True))
    elif block.zip is not None:
        for values in zip(*block.zip.values(), strict=True):
            yield dict(zip(block.zip, values, strict=True))
    elif block.list is not None:
        yield from block.list
    elif block.random is not None:
        yield from _drawn(block.random)


def _drawn(config: RandomConfig) -> Iterator[Parameters]:
    generator = random.Random(config.seed)
    for _ in range(config.count):
        yield {key: _draw(generator, values) for key, values in config.values.items()}


def _draw(generator: random.Random, values: RangeConfig | tuple[Any, ...]) -> Any:
    if not isinstance(values, RangeConfig):
        return values[generator.randrange(len(values))]
    low, high = values.low, values.high
    if values.scale == "powers_of_two":
        return low * 2 ** generator.randrange(int(high // low).bit_length())
    if isinstance(low, int) and isinstance(high, int):
        return generator.randint(low, high)
    return generator.uniform(low, high)


def _reads_back(text: str) -> bool:
    try:
        return parse(text, lambda mark: Location(""), Path()).plain() == text
    except ArchsimError:
        return False
