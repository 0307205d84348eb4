"""Which generators there are, and the check of their parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from archsim.errors import ArchsimError, Location, Problem, did_you_mean, fail
from archsim.scene.generators import (
    amphitheater,
    knights,
    knot_and_spheres,
    power_plant,
    quad_and_triangle,
    robots,
    simple_occluder,
    town,
)
from archsim.scene.mesh import Mesh


class Generator(NamedTuple):
    """A function of a random source and parameters; a whole default makes a parameter whole-numbered."""

    make: Callable[[np.random.Generator, Any], Mesh]
    num_triangles: Callable[[Any], int]
    defaults: Any  # NamedTuple of int and float: every parameter and its value when not given
    lowest: Any  # the same NamedTuple: the least value of each


MAX_TRIANGLES = 10_000_000  # more is a slip of the pen, and would exhaust the memory


def _generator(module: Any) -> Generator:
    """What a file of this folder defines."""
    return Generator(module.make, module.num_triangles, module.Parameters(), module.LOWEST)


GENERATORS: Mapping[str, Generator] = {
    "quad_and_triangle": _generator(quad_and_triangle),
    "knot_and_spheres": _generator(knot_and_spheres),
    "town": _generator(town),
    "robots": _generator(robots),
    "power_plant": _generator(power_plant),
    "simple_occluder": _generator(simple_occluder),
    "knights": _generator(knights),
    "amphitheater": _generator(amphitheater),
}


def make_mesh(
    generator: str, seed: int, parameters: Mapping[str, float], where: Location | None = None
) -> Mesh:
    """The mesh of a generator of GENERATORS. Raises ArchsimError with every wrong parameter."""
    if generator not in GENERATORS:
        hint = did_you_mean(generator, GENERATORS) or f"known are {', '.join(sorted(GENERATORS))}"
        raise fail(f"there is no mesh generator '{generator}'", where, hint)
    if seed < 0:
        raise fail(f"generator '{generator}': the seed must not be negative, but is {seed}", where)

    chosen = GENERATORS[generator]
    problems = [
        Problem(where, f"generator '{generator}': {what}", hint, f"parameters.{name}")
        for name, value in parameters.items()
        for what, hint in _problems(chosen, name, value)
    ]
    if problems:
        raise ArchsimError(problems)
    values = chosen.defaults._replace(**parameters)
    if chosen.num_triangles(values) > MAX_TRIANGLES:
        number = chosen.num_triangles(values)
        raise fail(
            f"generator '{generator}': {number} triangles, but at most {MAX_TRIANGLES} are made", where
        )
    return chosen.make(np.random.Generator(np.random.PCG64(seed)), values)


def _problems(generator: Generator, name: str, value: object) -> list[tuple[str, str | None]]:
    """What is wrong with one parameter, and a hint; empty when nothing is."""
    known = generator.defaults._fields
    if name not in known:
        hint = did_you_mean(name, known) or f"known are {', '.join(known)}"
        return [(f"there is no parameter '{name}'", hint)]
    wanted = int if isinstance(getattr(generator.defaults, name), int) else (int, float)
    if isinstance(value, bool) or not isinstance(value, wanted) or not math.isfinite(value):
        return [(f"{name} must be a {'whole' if wanted is int else 'finite'} number, not {value!r}", None)]
    lowest = getattr(generator.lowest, name)
    if value < lowest:
        return [(f"{name} must be at least {lowest}, not {value}", None)]
    return []
