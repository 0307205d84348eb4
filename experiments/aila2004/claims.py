"""What the paper claims or leaves open beyond table 1: `python claims.py ROW`, for a walkthrough's middle.

Prints a Markdown table.
Cache and number of PSV buffers, delay stream down to overflow, tile size, resolution, order of volumes, depth bounds
before Stage 1. Bytes and operations, without time.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from archsim.config import load_walkthrough
from archsim.raster.eye_view import eye_view
from archsim.run.shadow_volumes import method_of
from archsim.run.walkthrough import resources_of, scene_at
from archsim.scene.scene import load_scene
from archsim.shadow_volumes.comparison import COMBINED, DEPTH_BOUNDS, HIERARCHICAL, Traffic, draw, prepare

HERE = Path(__file__).resolve().parent
MB = 2**20
Line = tuple[str, Traffic, Traffic]  # what is changed, hierarchical, within depth bounds


def main() -> None:
    row = sys.argv[1]
    print("| change | H total [MB] | stencil | depth | PSV | delay stream | pixels [M] | DB : H pixels |")
    print("|---|---|---|---|---|---|---|---|")
    for what, own, bounded in lines(row):
        sizes = (own.total, own.stencil_shadow, own.depth_shadow, own.psv, own.delay_stream)
        numbers = " | ".join(f"{size / MB:.3f}" for size in sizes)
        ratio = bounded.processed / max(own.processed, 1)
        print(f"| {what} | {numbers} | {own.processed / 1e6:.3f} | {ratio:.2f} |", flush=True)


def lines(row: str) -> Iterator[Line]:
    """Each change by itself."""
    yield ("as configured", *_drawn(row))
    yield ("within depth bounds before Stage 1", *_drawn(row, variant=COMBINED))
    for size in ("1 KiB", "4 KiB", "8 KiB"):
        yield (f"PSV cache of {size}", *_drawn(row, [f"shadow_volumes.psv_cache.size={size}"]))
    for count in (1, 4, 8):
        yield (f"{count} PSV buffers", *_drawn(row, [f"shadow_volumes.psv_buffers={count}"]))
    for size in ("16 KiB", "4 KiB", "1 KiB", "128 B"):
        yield (f"delay stream of {size}", *_drawn(row, [f"shadow_volumes.delay_stream={size}"]))
    for tile in (4, 16):
        yield (f"tiles of {tile} x {tile}", *_drawn(row, [f"shadow_volumes.tile={tile}"]))
    yield ("2048 x 1536 pixels", *_drawn(row, ["scene.resolution=[2048,1536]"]))
    for order in ("reverse", "near_light", "large"):
        yield (f"volumes in order: {order}", *_drawn(row, [f"shadow_volumes.order={order}"]))


def _drawn(
    row: str, overrides: list[str] | None = None, variant: str = HIERARCHICAL
) -> tuple[Traffic, Traffic]:
    """(hierarchical, depth bounds) of the middle of a walkthrough."""
    config = load_walkthrough(HERE / f"{row}.yaml", overrides or [])
    scene = load_scene(scene_at(config, 0.5))
    method = method_of(config.shadow_volumes, resources_of(config.shadow_volumes))
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    light = np.asarray(scene.lights[config.shadow_volumes.light].position, np.float64)
    view = prepare(scene, light, seen, method)
    return tuple(draw(view, name, method.resources).traffic for name in (variant, DEPTH_BOUNDS))


if __name__ == "__main__":
    main()
