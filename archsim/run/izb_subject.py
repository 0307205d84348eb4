"""What an irregular shadow map is of: a light of a scene, or a light view drawn to statistics."""

from __future__ import annotations

import hashlib
from typing import NamedTuple

from archsim.config import DrawnIzbConfig, GridConfig, IzbConfig, RunConfig
from archsim.raster.eye_view import EyeView, eye_view
from archsim.run.rendering import Functional
from archsim.scene.scene import digest, load_scene
from archsim.shadow.drawn import Statistics, draw
from archsim.shadow.grid import Grid
from archsim.shadow.plain import FacePlan, Method, plan_faces


class Subject(NamedTuple):
    """What a run's scene and workload sections describe, without the machine."""

    seen: EyeView
    plans: list[FacePlan]  # of the light views
    digest: str  # of all that decides them


def grid_of(workload: GridConfig) -> Grid:
    """The grid of a checked workload section."""
    return Grid(*workload.logical_grid, *workload.physical_grid, *workload.grid_tile)


def subject_of(config: RunConfig | Functional) -> Subject:
    """The light views that a run is about."""
    workload = config.workload
    if isinstance(workload, DrawnIzbConfig):
        plan, seen = draw(_statistics(workload), grid_of(workload), workload.pixel_tile, config.seed)
        text = f"{workload.model_dump_json()} {config.seed}"
        return Subject(seen, [plan], hashlib.sha256(text.encode()).hexdigest())
    assert isinstance(workload, IzbConfig)
    scene = load_scene(config.scene)
    seen = eye_view(scene.mesh, scene.camera, scene.width, scene.height)
    method = Method(grid_of(workload), workload.pixel_tile, workload.depth_offset_cells)
    return Subject(seen, plan_faces(scene, seen, scene.lights[workload.light], method), digest(scene))


def _statistics(workload: DrawnIzbConfig) -> Statistics:
    return Statistics(
        workload.resolution,
        workload.list_length,
        workload.stencil,
        (workload.grid_fragments_pre_stencil, workload.grid_fragments_post_stencil),
        (workload.framebuffer_fragments_pre_z, workload.framebuffer_fragments_post_z),
        workload.patch,
        workload.triangle_order == "neighbours",
    )
