"""What the paper claims or leaves open beyond table 1: `python claims.py ROW [TOPIC ...]`, for a walkthrough's middle.

Prints a Markdown table. Topics: bounds (depth bounds before Stage 1), cache (of the PSV buffers), buffers, stream (the
delay stream, down to overflow), tiles (their size), resolution, order (of the volumes); all of them if none is named.
Bytes and operations, without time: configs/sweeps/hsv_*.yaml have the same with time.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from archsim.config import load_walkthrough
from archsim.run.shadow_volumes import method_of, prepare_light
from archsim.run.walkthrough import resources_of, scene_at
from archsim.scene.scene import load_scene
from archsim.shadow_volumes.comparison import COMBINED, DEPTH_BOUNDS, HIERARCHICAL, Traffic, draw

HERE = Path(__file__).resolve().parent
MB = 2**20


class Change(NamedTuple):
    """One line of the table."""

    what: str
    overrides: tuple[str, ...] = ()
    variant: str = HIERARCHICAL
    has_rival: bool = False  # drawn within depth bounds, too


CHANGES = {
    "bounds": [Change("within depth bounds before Stage 1", variant=COMBINED)],
    "cache": [
        Change(f"PSV cache of {size}", (f"shadow_volumes.psv_cache.size={size}",))
        for size in ("1 KiB", "4 KiB", "8 KiB")
    ],
    "buffers": [
        Change(f"{count} PSV buffers", (f"shadow_volumes.psv_buffers={count}",)) for count in (1, 4, 8)
    ],
    "stream": [
        Change(f"delay stream of {size}", (f"shadow_volumes.delay_stream={size}",))
        for size in ("16 KiB", "4 KiB", "1 KiB", "128 B")
    ],
    "tiles": [
        Change(f"tiles of {tile} x {tile}", (f"shadow_volumes.tile={tile}",), has_rival=True)
        for tile in (4, 16)
    ],
    "resolution": [Change("2048 x 1536 pixels", ("scene.resolution=[2048,1536]",), has_rival=True)],
    "order": [
        Change(f"volumes in order: {order}", (f"shadow_volumes.order={order}",))
        for order in ("reverse", "near_light", "large")
    ],
}


def main() -> None:
    row, *topics = sys.argv[1:]
    print("| change | H total [MB] | stencil | depth | PSV | delay stream | pixels [M] | DB : H pixels |")
    print("|---|---|---|---|---|---|---|---|")
    changes = [change for topic in topics or CHANGES for change in CHANGES[topic]]
    for change in [Change("as configured", has_rival=True), *changes]:
        print(_line(change.what, *_drawn(row, change)), flush=True)


def _drawn(row: str, change: Change) -> Iterator[Traffic]:
    """The middle of a walkthrough, changed: by the variant, and by its rival if that is wanted."""
    config = load_walkthrough(HERE / f"{row}.yaml", change.overrides)
    method = method_of(config.shadow_volumes, resources_of(config.shadow_volumes))
    view = prepare_light(load_scene(scene_at(config, 0.5)), config.shadow_volumes.light, method)
    for variant in (change.variant, DEPTH_BOUNDS)[: 1 + change.has_rival]:
        yield draw(view, variant, method.resources).traffic


def _line(what: str, own: Traffic, bounded: Traffic | None = None) -> str:
    sizes = (own.total, own.stencil_shadow, own.depth_shadow, own.psv, own.delay_stream)
    numbers = " | ".join(f"{size / MB:.3f}" for size in sizes)
    ratio = f"{bounded.processed / max(own.processed, 1):.2f}" if bounded else ""
    return f"| {what} | {numbers} | {own.processed / 1e6:.3f} | {ratio} |"


if __name__ == "__main__":
    main()
