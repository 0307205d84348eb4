"""One frame of a walkthrough: drawn by every variant, kept in a file when drawn, and read back.

A kept frame's name is a digest of its scene, of how it is drawn and of the code, so that it can only be taken for
what it is. Files are whole or not there at all.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from archsim.config import resolved_yaml
from archsim.config.walkthrough import PipelinedVolumesConfig
from archsim.jit import code_digest
from archsim.raster.eye_view import eye_view
from archsim.run.folder import write_whole
from archsim.run.progress import Progress, silent
from archsim.scene.scene import Scene, digest
from archsim.shadow_volumes.comparison import BRUTE_FORCE, VARIANTS, Method, Traffic, draw, prepare
from archsim.shadow_volumes.volumes import num_drawn

_STEPS = 20  # of progress in a variant


class Frame(NamedTuple):
    """One frame, drawn by every variant."""

    scene_digest: str
    triangles: int  # of all shadow volumes, as they are drawn
    volumes: int
    traffic: dict[str, Traffic]  # of each variant
    different: dict[str, int]  # pixels in which each variant's mask is not brute force's
    layers: list[int]  # pixels by how often brute force updates their stencil
    shadow: np.ndarray  # bool [height, width] by brute force


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
    volumes, shadow = view.seen.volumes, variants[BRUTE_FORCE].shadow
    layers = np.bincount(variants[BRUTE_FORCE].layers.ravel()).tolist()
    return Frame(
        digest(scene),
        num_drawn(volumes),
        len(volumes.z_pass),
        {name: variant.traffic for name, variant in variants.items()},
        {name: int((variant.shadow != shadow).sum()) for name, variant in variants.items()},
        layers,
        shadow,
    )


def kept_place(folder: Path, scene: Scene, config: PipelinedVolumesConfig) -> Path:
    """Where the frame of this scene is kept, or would be."""
    parts = (digest(scene), resolved_yaml(config), code_digest())
    name = hashlib.sha256("\n".join(parts).encode()).hexdigest()
    return folder / f"{name[:24]}.npz"


def keep(place: Path, frame: Frame) -> None:
    """Write a frame down."""
    numbers: dict[str, Any] = {**frame._asdict(), "shadow": None}
    numbers["traffic"] = {name: list(traffic) for name, traffic in frame.traffic.items()}
    stream = io.BytesIO()
    np.savez_compressed(stream, numbers=np.array(json.dumps(numbers)), shadow=frame.shadow)
    write_whole(place, stream.getvalue())


def kept(place: Path) -> Frame | None:
    """The frame that was kept there; None if there is none, or none that can be read."""
    try:
        with place.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            numbers, shadow = json.loads(str(file["numbers"])), file["shadow"]
        traffic = {name: Traffic(*values) for name, values in numbers["traffic"].items()}
        return Frame(**{**numbers, "traffic": traffic, "shadow": shadow})
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
        return None
