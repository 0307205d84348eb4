"""One light's shadow volumes on a pipeline: drawn, their work played, the mask checked against brute force."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.config import MachineConfig, RunConfig, ShadowVolumesConfig, VolumesConfig
from archsim.config.components import CacheConfig
from archsim.config.stages import DelayStreamConfig, PoolConfig
from archsim.errors import ArchsimError, Problem, fail
from archsim.machine.pipeline.build import PipelineMachine, pipeline_machine
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.pipeline.play import play
from archsim.raster.eye_view import eye_view
from archsim.run.listen import Listen
from archsim.run.measure import measured
from archsim.run.pipeline_metrics import pipeline_checks, pipeline_latencies, pipeline_statistics
from archsim.run.progress import Progress
from archsim.run.rendering import Functional, Kind, Piece, Play
from archsim.run.result import Check, Histogram, Result, Statistic
from archsim.run.shadow_volume_statistics import TRAFFIC, WORKLOAD
from archsim.scene.scene import Scene, digest, load_scene
from archsim.shadow_volumes.casters import Grouping
from archsim.shadow_volumes.comparison import BRUTE_FORCE, Method, Traffic, Variant, View, draw, prepare
from archsim.shadow_volumes.hierarchical import Resources
from archsim.shadow_volumes.order import Order
from archsim.shadow_volumes.psv_cache import CacheShape
from archsim.shadow_volumes.tiles import spread, tiled
from archsim.shadow_volumes.volumes import Counting, Extrusion
from archsim.shadow_volumes.work import UNITS, needed_bytes, pipeline_work
from archsim.trace.stream import PipelineWork

PHASE = "shadow_volumes"
PSV_BUFFERS, PSV_CACHE, DELAY_STREAM = "psv_buffers", "psv_cache", "delay_stream"  # components of the machine


class Facts(NamedTuple):
    """All that does not depend on the machine's speed, besides the work."""

    scene_digest: str
    statistics: list[Statistic]  # of workload and traffic
    traffic: Traffic
    mask: Check  # that it is brute force's
    shadow: np.ndarray  # as in Result
    histogram: Histogram
    maps: dict[str, np.ndarray]


class Played(NamedTuple):
    """What a pipeline made of a view."""

    statistics: list[Statistic]
    checks: list[Check]
    latencies: dict[str, np.ndarray]  # as in Result


def takes(config: RunConfig) -> Resources:
    """What picture and work take from the machine: who overflows what decides what is drawn and moved, and where."""
    return resources_of(config.machine)


def execute(functional: Functional, play: Play) -> Facts:
    """Draw the volumes of one light by units of the pipeline, and once more by brute force."""
    workload, resources = functional.workload, functional.taken
    assert isinstance(workload, ShadowVolumesConfig)
    method, scene = method_of(workload, resources), load_scene(functional.scene)
    view = prepare_light(scene, workload.light, method)
    play(pipeline_piece(view, workload.variant, resources, workload.submission == "twice"))
    expected, drawn = draw(view, BRUTE_FORCE, resources), draw(view, workload.variant, resources)
    return facts_of(digest(scene), view, drawn, equal_masks(drawn.shadow, expected.shadow))


def facts_of(scene_digest: str, view: View, drawn: Variant, masks: Check) -> Facts:
    """What is known of a view that is drawn."""
    return Facts(
        scene_digest,
        [*measured("workload", WORKLOAD, view), *measured("traffic", TRAFFIC, drawn.traffic)],
        drawn.traffic,
        masks,
        drawn.shadow,
        layer_histogram(np.bincount(drawn.layers.ravel())),
        layer_maps(view, drawn),
    )


def pipeline_piece(view: View, variant: str, resources: Resources, twice: bool) -> Piece:
    """The work of a pipeline that draws a view; `twice`: each volume is submitted twice."""
    work = pipeline_work(view, variant, resources, twice)
    return Piece(PHASE, work, needed_bytes(view.seen.screen, resources.num_psv_buffers))


class VolumesPlayer:
    """One light's volumes on the pipeline of a run."""

    def __init__(self, config: RunConfig, progress: Progress, listen: Listen):
        workload = config.workload
        assert isinstance(workload, ShadowVolumesConfig)
        self.name, twice = config.name, workload.submission == "twice"
        self.pipeline = OnPipeline(config.machine, Playing(config.model, twice, progress, listen))

    def play(self, piece: Piece) -> None:
        """Play all volumes."""
        self.pipeline.play(piece)

    def result(self, facts: Facts) -> Result:
        """The picture and what the pipeline took."""
        played = self.pipeline.played(facts.traffic)
        checks, statistics = [facts.mask, *played.checks], [*facts.statistics, *played.statistics]
        values = {statistic.name: statistic.value for statistic in statistics}
        summary = {name: values[name] for name in _FIRST}
        return Result(
            self.name,
            facts.scene_digest,
            {**summary, "checks_passed": all(check.ok for check in checks)},
            statistics,
            checks,
            facts.shadow,
            [facts.histogram],
            facts.maps,
            played.latencies,
        )


_FIRST = (
    "workload.triangles",
    "workload.volumes",
    "traffic.total",
    "traffic.processed",
    f"{PHASE}.cycles",
)


class Playing(NamedTuple):
    """How work is played on a pipeline."""

    model: str
    twice: bool  # each volume is submitted twice
    progress: Progress
    listen: Listen


class OnPipeline:
    """A view's work on a pipeline, and what came of it."""

    def __init__(self, config: MachineConfig, how: Playing):
        self.config, self.how, self.machine = config, how, pipeline_machine(config)
        self.counters: PipelineCounters | None = None

    def play(self, piece: Piece) -> None:
        """Play it. ArchsimError if the pipeline has no room for it."""
        assert isinstance(piece.work, PipelineWork)
        _check_memory(self.config, self.machine, piece.needed_bytes)

        def told(done: int) -> None:
            self.how.progress(PHASE, done, max(done, 1))

        heard = self.how.listen(PHASE, self.machine)
        self.counters = play(self.how.model, self.machine, piece.work, told, heard)

    def played(self, traffic: Traffic) -> Played:
        """What it came to; drawing it moves `traffic`."""
        counters, machine = self.counters, self.machine
        assert counters is not None
        checks = [
            *_traffic_checks(counters, traffic, self.how.twice),
            *pipeline_checks(PHASE, machine, counters),
        ]
        latencies = pipeline_latencies(PHASE, machine, counters)
        return Played(pipeline_statistics(PHASE, machine, counters), checks, latencies)


def layer_maps(view: View, drawn: Variant) -> dict[str, np.ndarray]:
    """How often the stencil of each pixel was updated, and the mean of each tile; NaN where it never was.

    Hierarchically drawn, what shows are the tiles with a boundary.
    """
    screen = view.seen.screen
    of_tiles = spread(screen, tiled(drawn.layers, screen.tile, 0).mean(axis=1))
    return {
        "Stencil updates of each pixel; grey: none [updates]": _or_none(drawn.layers),
        "Stencil updates a pixel, tile by tile; grey: none [updates]": _or_none(of_tiles),
    }


def _or_none(layers: np.ndarray) -> np.ndarray:
    """float32, NaN for 0."""
    return np.where(layers > 0, layers, np.nan).astype(np.float32)


def layer_histogram(pixels: np.ndarray) -> Histogram:
    """Of pixels by how often their stencil was updated: the depth complexity of what was drawn."""
    return Histogram("Depth complexity: stencil updates of a pixel", "updates", "pixels", pixels)


def equal_masks(shadow: np.ndarray, expected: np.ndarray) -> Check:
    """The law that a mask is brute force's."""
    different = int((shadow != expected).sum())
    return Check("shadow mask of brute force", different == 0, f"{different} pixels differ")


def prepare_light(scene: Scene, light: int, method: Method) -> View:
    """The volumes of one of the scene's lights in its view."""
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    return prepare(scene, np.asarray(scene.lights[light].position, np.float64), seen, method)


def method_of(config: VolumesConfig, resources: Resources) -> Method:
    """The algorithm's choices in a checked section."""
    grouping, counting = Grouping[config.casters.upper()], Counting[config.counting.upper()]
    extrusion = Extrusion(grouping, counting, config.range, Order[config.order.upper()])
    return Method(extrusion, config.tile, resources)


def resources_of(machine: MachineConfig) -> Resources:
    """What the machine has for the hierarchical algorithm. ArchsimError if something is missing."""
    kinds = {PSV_BUFFERS: "pool", PSV_CACHE: "cache", DELAY_STREAM: "delay_stream"}
    problems = [
        Problem(
            None,
            f"machine '{machine.name}' has no {kind} '{name}', which shadow volumes need",
            key=machine.key_of(kind),
        )
        for name, kind in kinds.items()
        if name not in machine.components or machine.components[name].kind != kind
    ]
    if problems:
        raise ArchsimError(problems)
    pool, cache, stream = (machine.components[name] for name in kinds)
    assert isinstance(pool, PoolConfig)
    assert isinstance(cache, CacheConfig)
    assert isinstance(stream, DelayStreamConfig)
    return Resources(pool.count, CacheShape(cache.size, cache.line, cache.ways), stream.size)


def _check_memory(config: MachineConfig, machine: PipelineMachine, needed: int) -> None:
    """ArchsimError if the buffers do not fit into the memory, or reach into the delay stream."""
    stream = config.components[DELAY_STREAM]
    assert isinstance(stream, DelayStreamConfig)
    free = min(machine.dram_bytes, stream.address)
    if needed > free:
        what = f"the buffers of this run end at {needed} bytes, but memory or delay stream at {free}"
        raise fail(what, key=config.key_of("dram" if free == machine.dram_bytes else "delay_stream"))


def _traffic_checks(counters: PipelineCounters, traffic: Traffic, twice: bool) -> list[Check]:
    """What the units moved is what the algorithm says."""
    loaded = dict(zip(UNITS, counters.unit_load_bytes.tolist(), strict=True))
    stored = dict(zip(UNITS, counters.unit_store_bytes.tolist(), strict=True))
    pairs = [
        ("stencil bytes", loaded["stencil"] + stored["stencil"], traffic.stencil_shadow),
        ("depth bytes", loaded["depth"], traffic.depth_shadow),
        ("lighting bytes", loaded["lighting"], traffic.stencil_lighting),
        ("delay stream bytes", 2 * int(counters.stream_bytes.sum()), 0 if twice else traffic.delay_stream),
    ]
    return [Check(f"{PHASE}: {name} = the algorithm's", a == b, f"{a} = {b}") for name, a, b in pairs]


KIND = Kind(takes, execute, VolumesPlayer)
