"""The grid of lists: logical cells, the hash-like map to physical cells, and where a cell's list head is stored.

[Johnson04] sec. 5. The logical grid overlays the light view; each logical cell shares a physical cell's list:

    physical i = (i + floor(j / physical width)  * tile width)  mod physical width
    physical j = (j + floor(i / physical height) * tile height) mod physical height

Heads are stored tile by tile. Physical sizes and tile sizes are powers of two: float32 arithmetic on them is exact.
"""

from __future__ import annotations

from typing import NamedTuple

from archsim.jit import njit


class Grid(NamedTuple):
    """Sizes in cells."""

    logical_width: int
    logical_height: int
    physical_width: int
    physical_height: int
    tile_width: int
    tile_height: int

    @property
    def num_physical_cells(self) -> int:
        return self.physical_width * self.physical_height

    @property
    def num_logical_cells(self) -> int:
        return self.logical_width * self.logical_height

    @property
    def tiles_wide(self) -> int:
        """Tiles in a row of the physical grid."""
        return self.physical_width // self.tile_width

    @property
    def tiles_high(self) -> int:
        """Tiles in a column of the physical grid."""
        return self.physical_height // self.tile_height

    @property
    def tile_area(self) -> int:
        return self.tile_width * self.tile_height


@njit
def physical_cell(grid, i, j):
    """Physical cell (i, j) of logical cell (i, j)."""
    physical_i = (i + j // grid.physical_width * grid.tile_width) % grid.physical_width
    physical_j = (j + i // grid.physical_height * grid.tile_height) % grid.physical_height
    return physical_i, physical_j


@njit
def head_index(grid, i, j):
    """Position of physical cell (i, j) among the list heads, which are stored tile by tile, row by row."""
    area = grid.tile_width * grid.tile_height
    tiles_wide = grid.physical_width // grid.tile_width
    tile = j // grid.tile_height * tiles_wide + i // grid.tile_width
    return tile * area + j % grid.tile_height * grid.tile_width + i % grid.tile_width


@njit
def head_of_logical(grid, i, j):
    """Position of the list head that logical cell (i, j) uses."""
    physical_i, physical_j = physical_cell(grid, i, j)
    return head_index(grid, physical_i, physical_j)
