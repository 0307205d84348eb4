"""A walkthrough with shadow volumes, untimed: the three variants of [Aila04] in every frame, averaged."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np

from archsim.config import WalkthroughConfig
from archsim.config.walkthrough import PipelinedVolumesConfig
from archsim.run.frames import Frame, draw_frame, keep, kept, kept_place
from archsim.run.measure import Measure, measured
from archsim.run.progress import Progress, silent
from archsim.run.result import Check, Result
from archsim.run.shadow_volume_statistics import TRAFFIC, average
from archsim.run.shadow_volumes import layer_histogram, method_of
from archsim.scene.scene import Scene, load_scene
from archsim.shadow_volumes.comparison import BRUTE_FORCE, VARIANTS, Method, Traffic
from archsim.shadow_volumes.hierarchical import Resources
from archsim.shadow_volumes.psv_cache import CacheShape

FIRST = ("walkthrough.frames", "walkthrough.triangles")


def simulate_walkthrough(
    config: WalkthroughConfig, progress: Progress = silent, folder: Path | None = None
) -> Result:
    """All frames of a walkthrough; statistics are averages over them, the mask is the last frame's.

    Frames are kept in `folder` as they are drawn; those that are there are not drawn again.
    """
    return _result(config, drawn_frames(config, progress, folder))


def drawn_frames(
    config: WalkthroughConfig, progress: Progress = silent, folder: Path | None = None
) -> list[Frame]:
    """All frames of a walkthrough, drawn by every variant or taken from `folder`."""
    method = method_of(config.shadow_volumes, resources_of(config.shadow_volumes))
    frames = []
    for number, scene in enumerate(scenes(config)):

        def told(what: str, done: int, total: int, number: int = number) -> None:
            progress(what, number * total + done, config.frames * total)

        frames.append(_frame(config, scene, method, told, folder))
    return frames


def _frame(
    config: WalkthroughConfig, scene: Scene, method: Method, progress: Progress, folder: Path | None
) -> Frame:
    """One frame, from the folder if it is there."""
    place = folder and kept_place(folder, scene, config.shadow_volumes)
    frame = kept(place) if place else None
    if frame is not None:
        for name in frame.traffic:
            progress(name, 1, 1)
        return frame

    light = np.asarray(scene.lights[config.shadow_volumes.light].position, np.float64)
    frame = draw_frame(scene, light, method, progress)
    if place:
        keep(place, frame)
    return frame


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
        "triangles",
        "triangles",
        "Of all shadow volumes, as they are drawn.",
        lambda frames: mean(f.triangles for f in frames),
    ),
    Measure("volumes", "volumes", "Shadow volumes.", lambda frames: mean(f.volumes for f in frames)),
]


def _result(config: WalkthroughConfig, frames: list[Frame]) -> Result:
    statistics = measured("walkthrough", COUNTS, frames)
    for name in VARIANTS:
        statistics += measured(name, TRAFFIC, average([frame.traffic[name] for frame in frames]))
    checks = [check for index, frame in enumerate(frames) for check in _checks(index, frame)]
    values = {statistic.name: statistic.value for statistic in statistics}
    summary = {key: values[key] for key in (*FIRST, *(f"{name}.total" for name in VARIANTS))}
    summary["checks_passed"] = all(check.ok for check in checks)
    layers = [sum(each) for each in zip_longest(*(frame.layers for frame in frames), fillvalue=0)]
    histograms = [layer_histogram(np.array(layers))]
    return Result(
        config.name, frames[-1].scene_digest, summary, statistics, checks, frames[-1].shadow, histograms, {}
    )


def _checks(index: int, frame: Frame) -> list[Check]:
    """What must hold in every frame."""
    brute = frame.traffic[BRUTE_FORCE]
    checks = []
    for name, different in frame.different.items():
        checks.append(
            Check(f"frame {index}: {name}: shadow mask of brute force", different == 0, f"{different} differ")
        )
        more = _more_than(frame.traffic[name], brute)
        checks.append(
            Check(f"frame {index}: {name}: no more pixels than brute force", not more, ", ".join(more))
        )
    return checks


def _more_than(traffic: Traffic, brute: Traffic) -> list[str]:
    """What of a variant is more than brute force needs, and must not be."""
    rows = ("stencil_pixels", "depth_shadow", "stencil_shadow")
    return [row for row in rows if getattr(traffic, row) > getattr(brute, row)]
