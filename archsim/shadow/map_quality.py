"""How good shadow maps of any size are on one scene: conventional, adaptive and irregular, against ray tracing.

Every light of the scene gets its own map. A map's view is as narrow as the samples allow. The biases of conventional
and adaptive maps are sought for each map, so that the picture comes as near to the ray-traced one as it can.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, partial
from itertools import product
from typing import NamedTuple

import numpy as np

from archsim.raster.eye_view import EyeView, eye_view
from archsim.scene.scene import Light, Scene
from archsim.shadow import adaptive_map, plain, ray_trace
from archsim.shadow.adaptive_map import PAGE_TEXELS, Rendered
from archsim.shadow.grid import Grid
from archsim.shadow.izb import place_samples
from archsim.shadow.pixel_tiles import untile
from archsim.shadow.plain import FacePlan, Method, plan_faces
from archsim.shadow.shading import l2_difference, unshadowed
from archsim.shadow.shadow_map import Lookup, Receivers, plane_numbers, render, shadowed, surfaces

TILE = (8, 8)  # pixels; only the order of samples depends on it
SLOPE_FACTORS = (0.0, 0.5, 1.0, 2.0, 4.0)
CONSTANTS = (0.0, 2.0**-18, 2.0**-15, 2.0**-12, 2.0**-9)
METHODS = {  # name -> a lookup without its bias
    "nearest texel": Lookup(0, 0.0, 0.0, False),
    "PCF 3 x 3": Lookup(1, 0.0, 0.0, False),
    "PCF 3 x 3, surface numbers": Lookup(1, 0.0, 0.0, True),
}
ADAPTIVE, IRREGULAR = "adaptive", "irregular"


class Point(NamedTuple):
    """A method at one size."""

    method: str
    num_samples: int  # of the shadow maps of all lights
    l2: float  # see shading.l2_difference


class Stage(NamedTuple):
    """A scene with all that is rendered once."""

    scene: Scene
    seen: EyeView
    planes: np.ndarray  # int32 [num_triangles]
    light: list[np.ndarray]  # float64 [height, width] what each light adds where it is not shadowed
    reference: list[np.ndarray]  # bool [height, width] in shadow of each light, ray traced


def stage_of(scene: Scene) -> Stage:
    """Eye view, shading and ray-traced shadows of a scene."""
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    lights = range(len(scene.lights))
    free = scene._replace(lights=tuple(Light(light.position, None) for light in scene.lights))
    return Stage(
        free,
        seen,
        plane_numbers(scene.mesh),
        [unshadowed(free, seen, light) / len(lights) for light in lights],
        [ray_trace.shadow_mask(free, light, seen) for light in lights],
    )


def quality(stage: Stage, sizes: Sequence[int], num_levels: int) -> Iterator[Point]:
    """Points of all methods: conventional maps of `sizes` texels on a side, adaptive ones of up to `num_levels`."""
    lights = range(len(stage.scene.lights))
    for size in sizes:
        maps = [_maps(stage, light, size) for light in lights]
        num_texels = sum(len(faces) for faces in maps) * size * size
        for name, lookup in METHODS.items():
            shares = [_conventional(stage, light, maps[light], lookup) for light in lights]
            yield Point(name, num_texels, _error(stage, shares))
    adaptive = [_adaptive(stage, light, num_levels) for light in lights]
    for step in zip(*adaptive, strict=True):
        yield Point(ADAPTIVE, sum(texels for texels, _ in step), _error(stage, [share for _, share in step]))
    masks = [_irregular(stage, light) for light in lights]
    yield Point(IRREGULAR, len(masks) * stage.seen.triangle.size, _error(stage, masks))


def _error(stage: Stage, shares: Sequence[np.ndarray]) -> float:
    """Of the picture with these shares of shadow, against the ray-traced one."""
    image = sum(light * (1 - share) for light, share in zip(stage.light, shares, strict=True))
    truth = sum(light * (1 - shadow) for light, shadow in zip(stage.light, stage.reference, strict=True))
    return l2_difference(np.asarray(image), np.asarray(truth))


def _light_error(stage: Stage, light: int, share: np.ndarray) -> float:
    """Of what one light adds to the picture."""
    return l2_difference(stage.light[light] * share, stage.light[light] * stage.reference[light])


def _plans(stage: Stage, light: int, texels: int) -> list[FacePlan]:
    grid = Grid(texels, texels, texels, texels, 1, 1)
    return plan_faces(stage.scene, stage.seen, stage.scene.lights[light], Method(grid, TILE, 0.0))


def _rendered(stage: Stage, plan: FacePlan, texels: int) -> Rendered:
    """A face's map, its surfaces and the samples that it takes."""
    samples = place_samples(plan.tiles, plan.transform)
    pixel = np.maximum(plan.tiles.pixel, 0)
    own = stage.planes[np.maximum(stage.seen.triangle.ravel()[pixel], 0)]
    found = surfaces(plan.occluders, stage.planes)
    return render(plan.occluders, texels, texels), found, Receivers(samples.position, own)


def _image(stage: Stage, plan: FacePlan, share: np.ndarray) -> np.ndarray:
    return untile(plan.tiles, share, *stage.seen.triangle.shape)


def _biased(lookup: Lookup) -> Iterator[Lookup]:
    for factor, constant in product(SLOPE_FACTORS, CONSTANTS):
        yield lookup._replace(slope_factor=factor, constant=constant)


def _maps(stage: Stage, light: int, texels: int) -> list[tuple[FacePlan, Rendered]]:
    """A light's views, each with its map."""
    return [(plan, _rendered(stage, plan, texels)) for plan in _plans(stage, light, texels)]


def _conventional(
    stage: Stage, light: int, maps: Sequence[tuple[FacePlan, Rendered]], lookup: Lookup
) -> np.ndarray:
    """The share of shadow [height, width] under the bias that suits the maps best."""

    def image_of(biased: Lookup) -> np.ndarray:
        return np.asarray(sum(_image(stage, plan, shadowed(*face, biased)) for plan, face in maps))

    return min(map(image_of, _biased(lookup)), key=lambda share: _light_error(stage, light, share))


def _adaptive(stage: Stage, light: int, num_levels: int) -> list[tuple[int, np.ndarray]]:
    """The same for adaptive maps of at most 1, 4, 16 ... pages a face, up to `num_levels` such sizes."""
    finest = PAGE_TEXELS << (num_levels - 1)
    budgets = [(PAGE_TEXELS << level) ** 2 for level in range(num_levels)]
    num_faces = len(_plans(stage, light, finest))

    @cache
    def face_at(texels: int, face: int) -> Rendered:
        return _rendered(stage, _plans(stage, light, texels)[face], texels)

    plan_of = _plans(stage, light, finest)
    best: list[tuple[float, int, np.ndarray]] = []
    for biased in _biased(Lookup(1, 0.0, 0.0, True)):
        sizes, images = np.zeros(num_levels, np.int64), np.zeros((num_levels, *stage.seen.triangle.shape))
        for face in range(num_faces):
            levels = adaptive_map.levels(partial(face_at, face=face), num_levels, biased)
            for step, refined in enumerate(adaptive_map.refine(levels, budgets)):
                sizes[step] += refined.num_texels
                images[step] += _image(stage, plan_of[face], refined.shadowed)
        found = [
            (_light_error(stage, light, image), int(size), image)
            for size, image in zip(sizes, images, strict=True)
        ]
        best = (
            [min(pair, key=lambda each: each[0]) for pair in zip(best, found, strict=True)] if best else found
        )
    return [(size, image) for _, size, image in best]


def _irregular(stage: Stage, light: int) -> np.ndarray:
    """The mask of an irregular shadow map on a grid of a quarter of a million cells.

    Occluders move by no more than the rounding error: a larger offset only takes shadow away from contacts and edges.
    """
    method = Method(Grid(512, 512, 256, 256, 8, 8), TILE, 0.0)
    mask, _ = plain.shadow_mask(stage.scene, stage.seen, stage.scene.lights[light], method)
    return mask.astype(float)
