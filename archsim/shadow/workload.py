"""What an irregular shadow map asks of a machine: the columns of [Johnson04] table 1."""

from __future__ import annotations

from typing import NamedTuple

from archsim.raster.conservative import Viewport


class IzbWorkload(NamedTuple):
    """Counts over one light view, or summed over several; ratios are properties."""

    samples: int
    non_empty_cells: int  # physical cells whose list holds a sample
    stencil_width: int  # extent of the populated logical cells
    stencil_height: int
    grid_fragments_pre_stencil: int
    grid_fragments_post_stencil: int
    node_visits: int  # list nodes tested, over all grid fragments
    framebuffer_fragments_pre_z: int
    framebuffer_fragments_post_z: int

    @property
    def list_length(self) -> float:
        """Samples in a list, averaged over the lists that have any."""
        return self.samples / self.non_empty_cells if self.non_empty_cells else 0.0

    @property
    def depth_complexity(self) -> float:
        """Triangles that cover a sample as seen from the light, averaged over samples."""
        return self.framebuffer_fragments_pre_z / self.samples if self.samples else 0.0


NOTHING = IzbWorkload(0, 0, 0, 0, 0, 0, 0, 0, 0)


def extent(viewport: Viewport) -> tuple[int, int]:
    """Width and height of the populated range of cells."""
    return viewport.i1 - viewport.i0, viewport.j1 - viewport.j0


def combined(a: IzbWorkload, b: IzbWorkload) -> IzbWorkload:
    """Two light views as one workload: counts add up, the stencil's extent is the larger one of the two."""
    total = IzbWorkload(*(x + y for x, y in zip(a, b, strict=True)))
    return total._replace(
        stencil_width=max(a.stencil_width, b.stencil_width),
        stencil_height=max(a.stencil_height, b.stencil_height),
    )
