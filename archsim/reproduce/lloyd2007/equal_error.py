"""Families of shadow maps with as many texels as it takes for equal errors in the image, over a camera path."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from archsim.lograster.offset import OffsetSpec, Switch
from archsim.reproduce.lloyd2007.aliasing import Fitted, fit_family
from archsim.reproduce.lloyd2007.views import Frame, load_walk
from archsim.run.shadow_maps import traced
from archsim.scene.mesh import Mesh
from archsim.scene.scene import Scene
from archsim.shadowmap.picture import Picture, take_picture
from archsim.shadowmap.render import render
from archsim.shadowmap.shadows import shadow_image

SCENE = "town"
TEXELS = 512 * 512  # of logpsm; the others get what the same error takes
IMAGE = 512
PERCENT = 95  # of pixels whose m is compared
OFFSET = OffsetSpec(1.0, 1e-6, int(Switch.INTERPOLATED))
STEPS, CLOSE = 8, 0.02  # attempts, and the relative difference that ends them
STEEPEST, FLATTEST = -1.0, -0.2  # powers of texels with which an error may fall


class Shot(NamedTuple):
    """A frame of the path, and what its shadows should be."""

    frame: Frame
    picture: Picture
    expected: np.ndarray  # bool [rows, columns] traced


class Errors(NamedTuple):
    """How far a family is off, over all frames."""

    m: float  # that PERCENT of all pixels stay below
    wrong: float  # share of all pixels whose shadow differs from the traced one


class Equal(NamedTuple):
    """A family with the texels that an equal error takes."""

    texels: int
    errors: Errors
    fitted: list[Fitted]  # for each frame


MEASURES: dict[
    str, tuple[str, tuple[str, ...]]
] = {  # what is made equal -> field of Errors, families compared
    "m": ("m", ("fp_lispsm", "csm_lispsm")),
    "wrong pixels": ("wrong", ("standard", "fp_lispsm", "csm_lispsm")),
}


def load_shots() -> tuple[Mesh, list[Shot]]:
    """The scene and every frame of its path."""
    walk = load_walk(SCENE)
    shots = []
    for frame in walk.frames:
        picture = take_picture(walk.mesh, frame.camera, frame.view, IMAGE, IMAGE)
        scene = Scene(walk.mesh, frame.camera, (), IMAGE, IMAGE, SCENE)
        shots.append(Shot(frame, picture, traced(scene, frame.view, frame.light, picture)))
    return walk.mesh, shots


def equal_errors(mesh: Mesh, shots: list[Shot]) -> Iterator[tuple[str, str, Equal]]:
    """(measure, family, Equal): first logpsm with TEXELS, then the others with the same of each measure."""

    def attempt(family: str, texels: int) -> Equal:
        fitted = [
            fit_family(family, shot.frame.view, shot.frame.light, shot.picture, texels) for shot in shots
        ]
        return Equal(texels, errors_of(mesh, shots, fitted), fitted)

    goal = attempt("logpsm", TEXELS)
    for measure, (field, families) in MEASURES.items():
        for family in families:
            yield measure, family, _equalled(family, attempt, field, getattr(goal.errors, field))
        yield measure, "logpsm", goal


def errors_of(mesh: Mesh, shots: list[Shot], fitted: list[Fitted]) -> Errors:
    """Of a family's maps for each frame."""
    wrong, seen = 0, 0
    for shot, each in zip(shots, fitted, strict=True):
        sizes = zip(each.maps, each.sizes, strict=True)
        depths = [render(mesh, shadow_map, size, OFFSET).depth for shadow_map, size in sizes]
        shadow = shadow_image(each.maps, depths, shot.frame.view, shot.picture)
        wrong += int((shadow != shot.expected)[shot.picture.seen].sum())
        seen += int(shot.picture.seen.sum())
    m = np.concatenate([each.errors.error for each in fitted])
    return Errors(float(np.percentile(m, PERCENT)), wrong / max(seen, 1))


def _equalled(family: str, attempt: Callable[[str, int], Equal], field: str, goal: float) -> Equal:
    """The attempt whose error comes nearest to a goal, by the secant through the last two, both in logarithms."""
    tried: list[tuple[float, float, Equal]] = []  # log texels, log of error over goal
    at, slope = math.log(TEXELS), -0.5
    for _ in range(STEPS):
        found = attempt(family, round(math.exp(at)))
        off = math.log(max(getattr(found.errors, field), 1e-12) / goal)
        if tried and at != tried[-1][0]:
            slope = (off - tried[-1][1]) / (at - tried[-1][0])
        tried.append((at, off, found))
        if abs(off) < CLOSE:
            break
        at -= off / min(max(slope, STEEPEST), FLATTEST)
    return min(tried, key=lambda each: abs(each[1]))[2]
