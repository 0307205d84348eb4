"""Shadow maps of one light: fitted to the view, drawn on a tile pipeline, looked up, compared with traced shadows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.config import RunConfig, ShadowMapsConfig
from archsim.lograster.offset import OffsetSpec, Switch
from archsim.raster.eye_view import eye_view
from archsim.run.listen import Listen
from archsim.run.measure import measured
from archsim.run.pipeline_metrics import pipeline_checks, pipeline_latencies, pipeline_statistics
from archsim.run.progress import Progress
from archsim.run.rendering import Functional, Kind, Piece, Play
from archsim.run.result import Check, Result, Statistic
from archsim.run.shadow_map_figures import depth_images, map_histograms
from archsim.run.shadow_map_statistics import (
    COMPARED,
    EACH,
    EVALUATOR,
    IMAGE,
    TOGETHER,
    Comparison,
    Frame,
    Together,
)
from archsim.run.tile_pipeline import (
    DrawnMap,
    Parts,
    PlayedMap,
    TilePlayer,
    cost_of,
    draw_maps,
    hardware_of,
    phase_of,
    targets_of,
)
from archsim.scene.scene import Light, Scene, digest, load_scene
from archsim.shadow.ray_trace import shadow_mask
from archsim.shadowmap.allocation import sizes_of
from archsim.shadowmap.families import make_maps
from archsim.shadowmap.fit import ShadowMap
from archsim.shadowmap.picture import Picture, aliasing, take_picture
from archsim.shadowmap.shadows import shadow_image
from archsim.shadowmap.view import View, directional_light, make_view, point_light

FAR_AWAY = 1e7  # of the view's far depth: where a sun stands for the ray tracer


class Fitted(NamedTuple):
    """The maps of a run and what they are for."""

    view: View
    light: np.ndarray  # float64 [4]
    maps: list[ShadowMap]
    sizes: list[tuple[int, int]]  # columns, rows of each


class Facts(NamedTuple):
    """All that does not depend on the machine's speed, besides the work."""

    scene_digest: str
    maps: list[DrawnMap]
    most_rows: int  # of a map
    statistics: list[Statistic]  # of the picture
    shadow: np.ndarray  # as in Result
    error_map: np.ndarray  # float32 [height, width] m


def takes(config: RunConfig) -> Parts:
    """What picture and work take from the machine."""
    return hardware_of(config.machine).parts


def execute(functional: Functional, play: Play) -> Facts:
    """Draw one light's shadow maps by units of the pipeline, and the picture with them."""
    workload = functional.workload
    assert isinstance(workload, ShadowMapsConfig)
    scene = load_scene(functional.scene)
    fitted = fit_maps(scene, workload)
    offset = OffsetSpec(workload.offset_scale, workload.offset_units, int(Switch.INTERPOLATED))
    targets = targets_of(functional.taken, fitted.maps, fitted.sizes, offset)
    maps = draw_maps(scene.mesh, fitted.maps, targets, play)

    picture = take_picture(scene.mesh, scene.camera, fitted.view, scene.width, scene.height)
    shadow = shadow_image(fitted.maps, [each.depth for each in maps], fitted.view, picture)
    errors = aliasing(fitted.maps, fitted.sizes, fitted.view, picture)
    statistics = measured("image", IMAGE, Frame(picture.seen, shadow, errors.error))
    if workload.compare == "ray_traced":
        expected = traced(scene, fitted.view, fitted.light, picture)
        statistics += measured("image", COMPARED, Comparison(picture.seen, shadow, expected))
    most_rows = max(rows for _, rows in fitted.sizes)
    return Facts(digest(scene), maps, most_rows, statistics, shadow, spread(picture, errors.error))


class MapsPlayer:
    """One light's shadow maps on the pipeline of a run."""

    def __init__(self, config: RunConfig, progress: Progress, listen: Listen):
        self.name, self.hardware = config.name, hardware_of(config.machine)
        self.tiles = TilePlayer(config.model, self.hardware.machine, progress, listen)

    def play(self, piece: Piece) -> None:
        """Play a map."""
        self.tiles.play(piece)

    def result(self, facts: Facts) -> Result:
        """The picture and what the pipeline took for each map."""
        machine, played = self.hardware.machine, self.tiles.played(facts.maps)
        tick_hertz = machine.tick_hertz / machine.spec.period_ticks
        cost = cost_of(self.hardware, facts.most_rows)
        statistics = [
            *measured("maps", TOGETHER, Together(played, tick_hertz)),
            *measured("evaluator", EVALUATOR, (cost, played)),
            *facts.statistics,
        ]
        checks: list[Check] = []
        latencies: dict[str, np.ndarray] = {}
        for each in played:
            phase = phase_of(each.map.shadow_map)
            statistics += measured(phase, EACH, each)
            statistics += pipeline_statistics(phase, machine, each.counters)
            latencies |= pipeline_latencies(phase, machine, each.counters)
            checks += [*_map_checks(each), *pipeline_checks(phase, machine, each.counters)]
        values = {statistic.name: statistic.value for statistic in statistics}
        first = {name: values[name] for name in _FIRST if name in values}
        return Result(
            self.name,
            facts.scene_digest,
            {**first, "checks_passed": all(check.ok for check in checks)},
            statistics,
            checks,
            facts.shadow,
            map_histograms(facts.maps),
            {
                "m, the size of a texel in the picture [pixels]": facts.error_map,
                **depth_images(facts.maps),
            },
            latencies,
        )


_FIRST = (
    "maps.count",
    "maps.texels",
    "maps.cycles",
    "maps.tiles_per_cycle",
    "maps.read_bytes",
    "maps.written_bytes",
    "maps.plain_bytes",
    "maps.compression",
    "image.m_95",
    "image.wrong_percent",
)


def fit_maps(scene: Scene, workload: ShadowMapsConfig) -> Fitted:
    """The maps that a checked section asks for."""
    view = make_view(scene.camera, scene.width / scene.height, workload.far)
    if workload.sun is not None:
        light = directional_light(np.array(workload.sun, dtype=np.float64))
    else:
        light = point_light(np.asarray(scene.lights[workload.light].position, dtype=np.float64))
    maps = make_maps(workload.maps, view, light)
    sizes = sizes_of(workload.maps, maps, view, scene.height, workload.texels[0] * workload.texels[1])
    if workload.rasterization == "linear":
        maps = [shadow_map._replace(ratio=1.0) for shadow_map in maps]
    return Fitted(view, light, maps, sizes)


def traced(scene: Scene, view: View, light: np.ndarray, picture: Picture) -> np.ndarray:
    """Shadows of a light float64 [4] traced ray by ray; bool [height, width], False beyond the view."""
    place = light[:3] if light[3] else view.eye + FAR_AWAY * view.far * light[:3]
    lit = scene._replace(lights=(Light(place, None),))
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    return np.asarray(shadow_mask(lit, 0, seen) & picture.seen)


def spread(picture: Picture, values: np.ndarray) -> np.ndarray:
    """Values [n] of the pixels seen as an image float32, NaN elsewhere."""
    image = np.full(picture.seen.shape, np.nan, np.float32)
    image[picture.seen] = values
    return image


def _map_checks(played: PlayedMap) -> list[Check]:
    """The pipeline leaves the picture that drawing gives, and moves whole blocks."""
    name, moved = phase_of(played.map.shadow_map), played.map.plain
    different = int((played.map.depth != played.map.drawn.depth).sum())
    counts, flush = played.map.drawn.counts, 1
    tiles = played.tasks("fine") - flush, counts.tiles
    covered = played.tasks("z_cull") - flush, counts.covered_tiles
    return [
        Check(f"{name}: depths of drawing", different == 0, f"{different} samples differ"),
        Check(f"{name}: tiles of drawing", tiles[0] == tiles[1], f"{tiles[0]} = {tiles[1]}"),
        Check(f"{name}: covered tiles of drawing", covered[0] == covered[1], f"{covered[0]} = {covered[1]}"),
        Check(
            f"{name}: no more is moved than uncompressed",
            played.read <= moved[0] and played.written <= moved[1],
            f"{played.read} of {moved[0]} read, {played.written} of {moved[1]} written",
        ),
    ]


KIND = Kind(takes, execute, MapsPlayer)
