"""The workload section: what the machine computes on the scene."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, RootModel, Tag, model_validator

from archsim.config.machine import MachineConfig
from archsim.config.scene import Extent
from archsim.config.section import Finding, Section, Vector, is_power_of_two, key_of, report

MAX_PAIRS = (
    122  # of pixels in a tile: the build kernel holds their steps from c[11], their positions to c[254]
)
MAX_CELLS = 2**24  # integers that a float32 register holds exactly

Cells = Annotated[int, Field(ge=1, le=4096, json_schema_extra={"unit": "cells"})]
Size = Annotated[tuple[Cells, Cells], Field(strict=False)]
Texels = Annotated[int, Field(ge=4, le=16384, json_schema_extra={"unit": "texels"})]
Fragments = Annotated[int, Field(ge=1, le=10**10)]
_SIDES = ("width", "height")


class GridConfig(Section):
    """The grid of lists of an irregular z-buffer ([Johnson04] sec. 5). All sizes are [width, height]."""

    needs_scene: ClassVar[bool]

    kind: str
    logical_grid: Size  # cells
    physical_grid: Size  # cells
    grid_tile: Size  # cells; the physical grid is stored tile by tile
    pixel_tile: Size  # pixels; a task of the build phase
    tile_order: Literal["interleaved", "block"] = "interleaved"  # consecutive pixel tiles over build threads
    structure: Literal["list", "kd_tree"] = "list"  # what holds the samples of a cell
    # how depths, and nodes at their pixel's place, lie in memory: row by row of the image, or pixel tile by pixel tile
    pixel_layout: Literal["rows", "tiles"] = "rows"
    # pixel: a sample's node lies at its pixel's place; pool: threads take the next free nodes
    node_layout: Literal["pixel", "pool"] = "pixel"
    # from one list head to the next; 16 where loads and stores have 128 bits only
    head_bytes: Literal[4, 16] = 4
    locks: Annotated[int, Field(ge=1, le=256)] = (
        256  # on-chip locks that building uses; a cell has one of them
    )

    @model_validator(mode="after")
    def _check(self) -> GridConfig:
        report([*self._check_grids(), *self._check_pixel_tile()])
        return self

    def _check_grids(self) -> list[Finding]:
        found = []
        for axis, side in enumerate(_SIDES):
            tile = self.grid_tile[axis]
            for key, size in (("grid_tile", self.grid_tile), ("physical_grid", self.physical_grid)):
                if not is_power_of_two(size[axis]):
                    found.append(Finding((key, axis), f"the {side} must be a power of two, not {size[axis]}"))
            for key, size in (("physical_grid", self.physical_grid), ("logical_grid", self.logical_grid)):
                if size[axis] % tile:
                    what = f"the {side} must be a multiple of the grid_tile's {tile}, not {size[axis]}"
                    found.append(Finding((key, axis), what))
        cells = self.logical_grid[0] * self.logical_grid[1]
        if cells >= MAX_CELLS:
            what = (
                f"must have fewer than {MAX_CELLS} cells: the kernels number them in a float; it has {cells}"
            )
            found.append(Finding(("logical_grid",), what))
        return found

    def _check_pixel_tile(self) -> list[Finding]:
        width, height = self.pixel_tile
        if width % 2:
            return [Finding(("pixel_tile", 0), f"the width must be even (pixels go in pairs), not {width}")]
        if width * height // 2 > MAX_PAIRS:
            what = f"a tile has at most {MAX_PAIRS} pairs of pixels, not {width * height // 2}"
            return [Finding(("pixel_tile",), what)]
        return []


class IzbConfig(GridConfig):
    """Irregular shadow mapping of one light of the scene ([Johnson04])."""

    needs_scene: ClassVar[bool] = True

    kind: Literal["izb"]
    light: Annotated[int, Field(ge=0)]  # index into the scene's lights
    depth_offset_cells: Annotated[float, Field(ge=0, le=1000)] = 0.015625  # against self-shadowing

    def light_findings(self, num_lights: int) -> list[Finding]:
        """What is wrong with the light that is asked for."""
        return light_findings(self.light, num_lights)


class VolumesConfig(Section):
    """Shadow volumes of one light of the scene ([Aila04])."""

    needs_scene: ClassVar[bool] = True

    light: Annotated[int, Field(ge=0)]  # index into the scene's lights
    # what has a volume of its own: the mesh's objects, connected parts, all together, each triangle
    casters: Literal["objects", "parts", "whole", "triangles"] = "objects"
    counting: Literal["z_fail", "adaptive"] = "z_fail"  # adaptive: Z-pass for volumes off the near plane
    range: Annotated[float, Field(gt=0)] | None = None  # distance at which volumes end; null: at infinity
    tile: Literal[4, 8, 16] = 8  # pixels along a side
    # whose volumes are submitted first: as the mesh has its objects, the other way round, those of casters near the
    # light, those of large casters
    order: Literal["scene", "reverse", "near_light", "large"] = "scene"

    def light_findings(self, num_lights: int) -> list[Finding]:
        """What is wrong with the light that is asked for."""
        return light_findings(self.light, num_lights)


class ShadowVolumesConfig(VolumesConfig):
    """Shadow volumes of one light of the scene, drawn on a pipeline ([Aila04])."""

    kind: Literal["shadow_volumes"]
    variant: Literal["brute_force", "depth_bounds", "hierarchical", "combined"] = "hierarchical"  # how
    submission: Literal["once", "twice"] = "once"  # twice: in two passes, without the delay stream


class VolumeKernelsConfig(VolumesConfig):
    """Shadow volumes drawn hierarchically, both stages as programs on cores, beside a pipeline that does the same."""

    kind: Literal["shadow_volume_kernels"]
    variant: Literal["hierarchical", "combined"] = "hierarchical"  # combined: within depth bounds
    psv_buffers: Annotated[
        int, Field(ge=1, le=4096)
    ]  # volumes that Stage 1 classifies before Stage 2 takes over
    fixed_function: MachineConfig  # the pipeline; volumes are submitted to it twice, as to the cores


class ShadowMapsConfig(Section):
    """Shadow maps of one light, drawn in 4 x 4 tiles on a pipeline ([Lloyd07])."""

    needs_scene: ClassVar[bool] = True

    kind: Literal["shadow_maps"]
    light: Annotated[int, Field(ge=0)] = 0  # index into the scene's lights
    sun: Vector | None = None  # in place of a light: the direction towards one infinitely far away
    # how many maps there are, and how each is warped: archsim/shadowmap/README.md
    maps: Literal["standard", "lispsm", "fp_lispsm", "csm_lispsm", "logpsm"] = "logpsm"
    # logarithmic: rows spaced as `logpsm` says; linear: evenly
    rasterization: Literal["linear", "logarithmic"] = "logarithmic"
    # columns and rows that all maps together have the product of
    texels: Annotated[tuple[Texels, Texels], Field(strict=False)] = (512, 512)
    far: Annotated[float, Field(gt=0, le=1e9)]  # depth at which the view ends that the maps are made for
    offset_scale: Annotated[float, Field(ge=0, le=1000)] = 1.0  # of the slope of depth (polygon offset)
    offset_units: Annotated[float, Field(ge=0, le=1)] = 1e-6  # of the whole depth range
    # what the picture is compared with: shadows traced ray by ray, which takes long with millions of triangles
    compare: Literal["ray_traced", "none"] = "ray_traced"

    @model_validator(mode="after")
    def _check(self) -> ShadowMapsConfig:
        if self.rasterization == "logarithmic" and self.maps != "logpsm":
            what = (
                f"must be linear: only the maps of 'logpsm' have logarithmic rows, not those of '{self.maps}'"
            )
            report([Finding(("rasterization",), what)])
        if self.sun is not None and not any(self.sun):
            report([Finding(("sun",), "must not be zero: it is a direction")])
        return self

    def light_findings(self, num_lights: int) -> list[Finding]:
        """What is wrong with the light that is asked for."""
        return [] if self.sun is not None else light_findings(self.light, num_lights)

    def far_findings(self, near: float) -> Iterator[Finding]:
        """What is wrong with the depths of a view that begins at `near`."""
        if self.far <= near:
            what = f"must be above the camera's near, {near:g}, not {self.far:g}"
            yield Finding(("workload", "far"), what)


def light_findings(light: int, num_lights: int) -> list[Finding]:
    """What is wrong with a light that is asked for."""
    if light < num_lights:
        return []
    lights = "one light" if num_lights == 1 else f"{num_lights} lights"
    return [Finding(("light",), f"must be below {num_lights}, not {light}: the scene has {lights}")]


class DrawnIzbConfig(GridConfig):
    """An irregular shadow map without a scene: samples and triangles drawn to fit the given statistics."""

    needs_scene: ClassVar[bool] = False

    kind: Literal["izb_drawn"]
    resolution: Annotated[tuple[Extent, Extent], Field(strict=False)]  # pixels; each has a sample
    list_length: Annotated[float, Field(ge=1, le=1e6)]  # samples, averaged over the lists that have any
    stencil: Size  # cells from the first to the last that holds a sample
    grid_fragments_pre_stencil: Fragments  # cells overlapped by triangles
    grid_fragments_post_stencil: Fragments  # those that hold a sample
    framebuffer_fragments_pre_z: Fragments  # samples inside triangles
    framebuffer_fragments_post_z: Fragments  # those that pass the z test
    patch: Size = (64, 64)  # pixels of a surface, which is seen by the light as a rectangle of one density
    triangle_order: Literal["neighbours", "random"] = "neighbours"  # neighbours: as a mesh submits them

    @model_validator(mode="after")
    def _check_statistics(self) -> DrawnIzbConfig:
        report(list(self._statistics_findings()))
        return self

    def _statistics_findings(self) -> Iterator[Finding]:
        for axis, side in enumerate(_SIDES):
            if self.stencil[axis] > self.logical_grid[axis]:
                what = f"the {side} must be at most the logical grid's {self.logical_grid[axis]}"
                yield Finding(("stencil", axis), f"{what}, not {self.stencil[axis]}")
            if self.patch[axis] % self.pixel_tile[axis]:
                what = f"the {side} must be a multiple of the pixel_tile's {self.pixel_tile[axis]}"
                yield Finding(("patch", axis), f"{what}, not {self.patch[axis]}")
        cells = min(self.physical_grid[0] * self.physical_grid[1], self.stencil[0] * self.stencil[1])
        least = self.resolution[0] * self.resolution[1] / cells
        if self.list_length < least:
            what = f"must be at least {least:.4g}, not {self.list_length:g}: there are {cells} lists"
            yield Finding(("list_length",), what)
        for what, before, after in (
            ("grid_fragments", "pre_stencil", "post_stencil"),
            ("framebuffer_fragments", "pre_z", "post_z"),
        ):
            most = getattr(self, f"{what}_{before}")
            if getattr(self, f"{what}_{after}") > most:
                yield Finding((f"{what}_{after}",), f"must be at most {what}_{before}, {most}")


KINDS: dict[str, type[Section]] = {
    "izb": IzbConfig,
    "izb_drawn": DrawnIzbConfig,
    "shadow_volumes": ShadowVolumesConfig,
    "shadow_volume_kernels": VolumeKernelsConfig,
    "shadow_maps": ShadowMapsConfig,
}


def _kind_tag(workload: Any) -> str | None:
    kind = KINDS.get(key_of(workload, "kind") or "")
    return f"<{kind.__name__}>" if kind else None


WorkloadConfig = Annotated[
    Annotated[IzbConfig, Tag("<IzbConfig>")]
    | Annotated[DrawnIzbConfig, Tag("<DrawnIzbConfig>")]
    | Annotated[ShadowVolumesConfig, Tag("<ShadowVolumesConfig>")]
    | Annotated[VolumeKernelsConfig, Tag("<VolumeKernelsConfig>")]
    | Annotated[ShadowMapsConfig, Tag("<ShadowMapsConfig>")],
    Discriminator(_kind_tag),
]


class WorkloadFile(RootModel[WorkloadConfig]):
    """A workload by itself, of any kind."""
