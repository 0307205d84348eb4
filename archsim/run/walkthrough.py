"""A walkthrough with shadow volumes, untimed: the three variants of [Aila04] in every frame, averaged."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import mean
from typing import Any, NamedTuple

import numpy as np

from archsim.config import WalkthroughConfig
from archsim.config.walkthrough import PipelinedVolumesConfig
from archsim.raster.eye_view import eye_view
from archsim.run.measure import Measure, measured
from archsim.run.progress import Progress, silent
from archsim.run.result import Check, Result
from archsim.run.shadow_volume_statistics import TRAFFIC, average
from archsim.run.shadow_volumes import method_of
from archsim.scene.scene import Scene, digest, load_scene
from archsim.shadow_volumes.comparison import BRUTE_FORCE, VARIANTS, Method, Traffic, Variant, draw, prepare
from archsim.shadow_volumes.hierarchical import Resources
from archsim.shadow_volumes.psv_cache import CacheShape

_STEPS = 20  # of progress in a variant
FIRST = ("walkthrough.frames", "walkthrough.triangles")


class Frame(NamedTuple):
    """One frame, drawn by every variant."""

    scene_digest: str
    triangles: int  # of all shadow volumes
    volumes: int
    variants: dict[str, Variant]


def simulate_walkthrough(config: WalkthroughConfig, progress: Progress = silent) -> Result:
    """All frames of a walkthrough; statistics are averages over them, the mask is the last frame's."""
    method = method_of(config.shadow_volumes, resources_of(config.shadow_volumes))
    frames = []
    for number, scene in enumerate(scenes(config)):

        def told(what: str, done: int, total: int, number: int = number) -> None:
            progress(what, number * total + done, config.frames * total)

        light = np.asarray(scene.lights[config.shadow_volumes.light].position, np.float64)
        frames.append(draw_frame(scene, light, method, told))
    return _result(config, frames)


def draw_frame(scene: Scene, light: np.ndarray, method: Method, progress: Progress = silent) -> Frame:
    """Every variant's shadow mask of one light in one view, and what it moves."""
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    view = prepare(scene, light, seen, method)
    variants = {}
    for name in VARIANTS:

        def steps(number: int, name: str = name) -> Iterator[tuple[int, int]]:
            for step in range(_STEPS):
                progress(name, step, _STEPS)
                yield number * step // _STEPS, number * (step + 1) // _STEPS
            progress(name, _STEPS, _STEPS)

        variants[name] = draw(view, name, method.resources, steps)
    volumes = view.seen.volumes
    return Frame(digest(scene), len(volumes.triangles), len(volumes.z_pass), variants)


def resources_of(config: PipelinedVolumesConfig) -> Resources:
    """What a checked section gives the hierarchical algorithm."""
    cache = CacheShape(config.psv_cache.size, config.psv_cache.line, config.psv_cache.ways)
    return Resources(config.psv_buffers, cache, config.delay_stream)


def scenes(config: WalkthroughConfig) -> Iterator[Scene]:
    """The scene of each frame."""
    for number in range(config.frames):
        yield load_scene(scene_at(config, number / (config.frames - 1) if config.frames > 1 else 0.5))


def scene_at(config: WalkthroughConfig, time: float) -> Any:
    """The scene section at a time from 0 to 1, between its two keyframes."""
    place = time * (len(config.keyframes) - 1)
    before = min(int(place), max(len(config.keyframes) - 2, 0))
    one, other = config.keyframes[before], config.keyframes[min(before + 1, len(config.keyframes) - 1)]
    share = place - before

    def between(a: Any, b: Any) -> Any:
        return (
            tuple(between(x, y) for x, y in zip(a, b, strict=True))
            if isinstance(a, tuple)
            else a + share * (b - a)
        )

    scene: Any = config.scene
    camera = {
        key: between(getattr(one, key), getattr(other, key)) for key in ("eye", "target") if getattr(one, key)
    }
    lights = list(scene.lights)
    if one.light is not None:
        index = config.shadow_volumes.light
        lights[index] = lights[index].model_copy(update={"position": between(one.light, other.light)})
    changes = {"camera": scene.camera.model_copy(update=camera), "lights": tuple(lights)}
    if one.parameters:
        values = {key: between(value, other.parameters[key]) for key, value in one.parameters.items()}
        changes["mesh"] = scene.mesh.model_copy(update={"parameters": {**scene.mesh.parameters, **values}})
    return scene.model_copy(update=changes)


COUNTS = [
    Measure("frames", "frames", "Frames drawn; what follows are averages over them.", len),
    Measure(
        "triangles", "triangles", "Of all shadow volumes.", lambda frames: mean(f.triangles for f in frames)
    ),
    Measure("volumes", "volumes", "Shadow volumes.", lambda frames: mean(f.volumes for f in frames)),
]


def _result(config: WalkthroughConfig, frames: list[Frame]) -> Result:
    statistics = measured("walkthrough", COUNTS, frames)
    for name in VARIANTS:
        statistics += measured(name, TRAFFIC, average([frame.variants[name].traffic for frame in frames]))
    checks = [check for index, frame in enumerate(frames) for check in _checks(index, frame)]
    shadow = frames[-1].variants[BRUTE_FORCE].shadow
    values = {statistic.name: statistic.value for statistic in statistics}
    summary = {key: values[key] for key in (*FIRST, *(f"{name}.total" for name in VARIANTS))}
    summary["checks_passed"] = all(check.ok for check in checks)
    return Result(config.name, frames[-1].scene_digest, summary, statistics, checks, shadow, [], {})


def _checks(index: int, frame: Frame) -> list[Check]:
    """What must hold in every frame."""
    brute = frame.variants[BRUTE_FORCE]
    checks = []
    for name, variant in frame.variants.items():
        different = int((variant.shadow != brute.shadow).sum())
        checks.append(
            Check(f"frame {index}: {name}: shadow mask of brute force", different == 0, f"{different} differ")
        )
        more = _more_than(variant.traffic, brute.traffic)
        checks.append(
            Check(f"frame {index}: {name}: no more pixels than brute force", not more, ", ".join(more))
        )
    return checks


def _more_than(traffic: Traffic, brute: Traffic) -> list[str]:
    """What of a variant is more than brute force needs, and must not be."""
    rows = ("stencil_pixels", "depth_shadow", "stencil_shadow")
    return [row for row in rows if getattr(traffic, row) > getattr(brute, row)]
