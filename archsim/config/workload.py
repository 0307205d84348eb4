"""The workload section: what the machine computes on the scene."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from archsim.config.section import Finding, Section, is_power_of_two, report

MAX_PAIRS = 240  # of pixels in a tile: the build kernel holds their positions in c[15] to c[254]
MAX_CELLS = 2**24  # integers that a float32 register holds exactly

Cells = Annotated[int, Field(ge=1, le=4096, json_schema_extra={"unit": "cells"})]
Size = Annotated[tuple[Cells, Cells], Field(strict=False)]
_SIDES = ("width", "height")


class WorkloadConfig(Section):
    """Irregular shadow mapping of one light ([Johnson04]). All sizes are [width, height]."""

    kind: Literal["izb"]
    light: Annotated[int, Field(ge=0)]  # index into the scene's lights
    logical_grid: Size  # cells
    physical_grid: Size  # cells
    grid_tile: Size  # cells; the physical grid is stored tile by tile
    pixel_tile: Size  # pixels; a task of the build phase
    tile_order: Literal["interleaved", "block"] = "interleaved"  # consecutive pixel tiles over build threads
    depth_offset_cells: Annotated[float, Field(ge=0, le=1000)] = 0.015625  # against self-shadowing

    @model_validator(mode="after")
    def _check(self) -> WorkloadConfig:
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
