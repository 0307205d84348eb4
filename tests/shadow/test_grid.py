"""The map from logical to physical cells."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from archsim.shadow.grid import Grid, head_index, head_of_logical, physical_cell

powers = st.integers(1, 5).map(lambda k: 1 << k)


@st.composite
def grids(draw):
    tile_width, tile_height = draw(powers), draw(powers)
    physical = tile_width * draw(powers), tile_height * draw(powers)
    logical = tile_width * draw(st.integers(1, 40)), tile_height * draw(st.integers(1, 40))
    return Grid(*logical, *physical, tile_width, tile_height)


def test_equations_by_hand():
    """[Johnson04] sec. 5 with a 512 x 512 physical grid and 8 x 4 tiles."""
    grid = Grid(1024, 1024, 512, 512, 8, 4)
    assert physical_cell(grid, 100, 200) == (100, 200)
    assert physical_cell(grid, 100, 700) == (108, 188)
    assert physical_cell(grid, 600, 200) == (88, 204)
    assert physical_cell(grid, 511, 1023) == (7, 511)
    assert physical_cell(grid, 1023, 1023) == (7, 3)


def test_heads_lie_tile_by_tile():
    grid = Grid(16, 16, 16, 8, 4, 2)
    row_of_tiles = [head_index(grid, i, 0) for i in range(16)]
    assert row_of_tiles == [0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27]
    assert head_index(grid, 0, 1) == 4
    assert head_index(grid, 0, 2) == 32


@given(grids())
@settings(max_examples=30, deadline=None)
def test_every_head_has_one_place(grid):
    places = {head_index(grid, i, j) for i in range(grid.physical_width) for j in range(grid.physical_height)}
    assert places == set(range(grid.num_physical_cells))


@given(grids(), st.data())
@settings(deadline=None)
def test_a_logical_tile_stays_whole(grid, data):
    """Coherence survives the map: the cells of a logical tile lie next to each other in memory."""
    assume(grid.physical_width % grid.tile_height == 0 == grid.physical_height % grid.tile_width)
    tile_i = data.draw(st.integers(0, grid.logical_width // grid.tile_width - 1)) * grid.tile_width
    tile_j = data.draw(st.integers(0, grid.logical_height // grid.tile_height - 1)) * grid.tile_height
    heads = [
        head_of_logical(grid, tile_i + i, tile_j + j)
        for j in range(grid.tile_height)
        for i in range(grid.tile_width)
    ]
    np.testing.assert_array_equal(heads, heads[0] + np.arange(grid.tile_area))


@pytest.mark.parametrize("logical", [(512, 512), (256, 512)])
def test_a_logical_grid_within_the_physical_one_is_not_moved(logical):
    grid = Grid(*logical, 512, 512, 8, 8)
    assert all(physical_cell(grid, i, i % logical[1]) == (i, i % logical[1]) for i in range(logical[0]))
