"""The three variants of [Aila04] on one view, and what each moves over the memory bus: the rows of its table 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.raster.eye_view import EyeView
from archsim.scene.scene import Scene
from archsim.shadow_volumes.depth_bounds import depth_bounds
from archsim.shadow_volumes.direct import draw_directly
from archsim.shadow_volumes.hierarchical import MIXED, Resources, draw_hierarchically
from archsim.shadow_volumes.seen import SeenVolumes, Steps, at_once
from archsim.shadow_volumes.stencil import layers, values
from archsim.shadow_volumes.tiles import screen, tiled
from archsim.shadow_volumes.volumes import Extrusion, seen_by, shadow_volumes

STENCIL_BYTES = 1  # a pixel; read, and written again when it is changed
DEPTH_BYTES = 4  # a pixel, before compression
DEPTH_COMPRESSION = 0.5  # assumed by [Aila04] sec. 6

BRUTE_FORCE, DEPTH_BOUNDS, HIERARCHICAL, COMBINED = "brute_force", "depth_bounds", "hierarchical", "combined"
VARIANTS = (BRUTE_FORCE, DEPTH_BOUNDS, HIERARCHICAL)


class Method(NamedTuple):
    """The algorithm's choices."""

    extrusion: Extrusion
    tile: int  # pixels along a side: 4, 8 or 16
    resources: Resources


class Traffic(NamedTuple):
    """Bytes over the memory bus, and work, of one shadow mask and of the lighting pass that reads it."""

    stencil_shadow: int  # bytes
    depth_shadow: int
    stencil_lighting: int
    psv: int  # lines of the PSV buffers
    delay_stream: int  # written and read
    stencil_pixels: int  # stencil operations on pixels
    sample_operations: int  # stencil operations on the samples of tiles

    @property
    def total(self) -> int:
        """Bytes."""
        return self.stencil_shadow + self.depth_shadow + self.stencil_lighting + self.psv + self.delay_stream

    @property
    def processed(self) -> int:
        """What [Aila04] calls pixels in the shadow pass: operations on pixels and on samples."""
        return self.stencil_pixels + self.sample_operations


class Variant(NamedTuple):
    """One way to the shadow mask."""

    shadow: np.ndarray  # bool [height, width], False where the view shows nothing
    traffic: Traffic
    layers: (
        np.ndarray
    )  # int32 [height, width] stencil updates of each pixel: the depth complexity of what was drawn


class View(NamedTuple):
    """One light's volumes in one view."""

    seen: SeenVolumes  # without depth bounds
    bounds: np.ndarray  # float64 [num_volumes, 2]
    shown: np.ndarray  # bool [height, width] pixels that show something


def prepare(scene: Scene, light: np.ndarray, eye_view: EyeView, method: Method) -> View:
    """Shadow volumes of a light at `light`, their depth bounds, and the z-buffer that they are compared with."""
    volumes = shadow_volumes(scene, light, method.extrusion)
    points = seen_by(volumes.points, scene.camera, scene.width, scene.height)
    none = np.tile([0.0, np.inf], (len(volumes.z_pass), 1))
    depths = screen(eye_view.reciprocal_depth, scene.camera.near, method.tile)
    bounds = depth_bounds(scene, light, volumes.box, method.extrusion.range)
    return View(SeenVolumes(volumes, points, none, depths), bounds, eye_view.triangle >= 0)


def draw(view: View, variant: str, resources: Resources, steps: Steps = at_once) -> Variant:
    """Draw all volumes of a view by one of the variants, or by COMBINED: hierarchical within depth bounds."""
    seen = view.seen._replace(bounds=view.bounds) if is_bounded(variant) else view.seen
    if is_hierarchical(variant):
        return _hierarchical(view, seen, resources, steps)
    stencil, counts = draw_directly(seen, steps)
    traffic = Traffic(
        stencil_shadow=2 * STENCIL_BYTES * counts.stencil_pixels,
        depth_shadow=_depth_bytes(seen, counts.depth_tiles),
        stencil_lighting=STENCIL_BYTES * int(view.shown.sum()),
        psv=0,
        delay_stream=0,
        stencil_pixels=counts.stencil_pixels,
        sample_operations=0,
    )
    shadow = view.shown & (values(seen.screen, stencil) > 0)
    return Variant(shadow, traffic, layers(seen.screen, stencil))


def is_bounded(variant: str) -> bool:
    """Whether tiles outside a volume's depth bounds are left out."""
    return variant in (DEPTH_BOUNDS, COMBINED)


def is_hierarchical(variant: str) -> bool:
    """Whether tiles are classified before they are drawn."""
    return variant in (HIERARCHICAL, COMBINED)


def _hierarchical(view: View, seen: SeenVolumes, resources: Resources, steps: Steps) -> Variant:
    outcome = draw_hierarchically(seen, resources, steps)
    counts, tile = outcome.counts, seen.screen.tile
    lit_tiles = tiled(view.shown, tile, 0).any(axis=1)
    fetched = int((lit_tiles & (outcome.state == MIXED)).sum())
    psv_lines = counts.psv_lines_read + counts.psv_lines_written
    traffic = Traffic(
        stencil_shadow=2 * STENCIL_BYTES * counts.stencil_pixels,
        depth_shadow=_depth_bytes(seen, counts.depth_tiles),
        stencil_lighting=STENCIL_BYTES * tile * tile * fetched,
        psv=psv_lines * resources.psv_cache.line_bytes,
        delay_stream=counts.delay_stream_bytes,
        stencil_pixels=counts.stencil_pixels,
        sample_operations=counts.sample_operations,
    )
    return Variant(view.shown & outcome.shadow, traffic, outcome.layers)


def _depth_bytes(seen: SeenVolumes, tiles: int) -> int:
    """Of fetched tiles of the z-buffer."""
    return int(tiles * seen.screen.tile**2 * DEPTH_BYTES * DEPTH_COMPRESSION)
