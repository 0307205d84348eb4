"""Drawn light views: the statistics that were asked for come out, the same seed gives the same view."""

from __future__ import annotations

import numpy as np
import pytest

from archsim.errors import ArchsimError
from archsim.shadow.drawn import Statistics, draw
from archsim.shadow.drawn_samples import draw_samples
from archsim.shadow.grid import Grid
from archsim.shadow.izb import in_shadow as lists_shadow
from archsim.shadow.izb import in_shadow_brute_force, place_samples
from archsim.shadow.plain import run_face

GRID = Grid(128, 128, 64, 64, 8, 8)
WANTED = Statistics((160, 128), 6.0, (80, 90), (26_000, 20_000), (60_000, 19_000), (16, 16), True)


@pytest.fixture(scope="module")
def plan():
    return draw(WANTED, GRID, (8, 8), 1)[0]


def test_the_statistics_come_out(plan):
    found = run_face(plan, GRID).workload
    assert found.samples == 160 * 128
    assert (found.stencil_width, found.stencil_height) == WANTED.stencil
    assert found.list_length == pytest.approx(WANTED.list_length, rel=0.01)
    assert found.grid_fragments_pre_stencil == pytest.approx(WANTED.grid_fragments[0], rel=0.02)
    assert found.grid_fragments_post_stencil == pytest.approx(WANTED.grid_fragments[1], rel=0.02)
    assert found.framebuffer_fragments_pre_z == pytest.approx(WANTED.framebuffer_fragments[0], rel=0.02)
    assert found.framebuffer_fragments_post_z == pytest.approx(WANTED.framebuffer_fragments[1], rel=0.02)


def test_no_hit_is_lost_between_cells(plan):
    outcome = run_face(plan, GRID)
    samples = place_samples(plan.tiles, plan.transform)
    expected = in_shadow_brute_force(samples, plan.occluders)
    assert np.array_equal(lists_shadow(outcome.z_test, outcome.samples), expected)


def test_a_seed_is_a_view(plan):
    again = draw(WANTED, GRID, (8, 8), 1)[0]
    other = draw_samples(WANTED, GRID, (8, 8), np.random.default_rng([2, 0]))
    assert np.array_equal(again.tiles.origins, plan.tiles.origins)
    assert np.array_equal(again.occluders.edges, plan.occluders.edges)
    assert not np.array_equal(other.tiles.origins, plan.tiles.origins)


def test_neighbours_follow_each_other(plan):
    def mean_distance(view):
        bounds = view.occluders.setup.bounds
        middle = 0.5 * (bounds[:, :2] + bounds[:, 2:])
        return np.linalg.norm(np.diff(middle, axis=0), axis=1).mean()

    random = draw(WANTED._replace(neighbours=False), GRID, (8, 8), 1)[0]
    assert len(random.occluders.depth) == len(plan.occluders.depth)
    assert mean_distance(plan) < 0.5 * mean_distance(random)


def test_pixels_beyond_whole_tiles_and_patches_have_samples():
    wanted = WANTED._replace(resolution=(157, 121))
    assert run_face(draw(wanted, GRID, (8, 8), 0)[0], GRID).workload.samples == 157 * 121


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"list_length": 3.0}, "cannot draw a workload of 3 lists' length"),
        ({"grid_fragments": (300, 200)}, "cannot draw a workload of [23]00 grid fragments"),
    ],
)
def test_what_cannot_be_drawn_is_said(changed, message):
    with pytest.raises(ArchsimError, match=message):
        draw(WANTED._replace(**changed), GRID, (8, 8), 1)


def test_larger_patches_are_drawn_where_triangles_fit_no_others():
    """Few triangles that cover much: surfaces of 16 x 16 pixels are strewn too widely for them."""
    changed = {"grid_fragments": (4_000, 2_000), "framebuffer_fragments": (40_000, 15_000)}
    wanted = WANTED._replace(list_length=20.0, stencil=(50, 50), **changed)
    plan, seen = draw(wanted, GRID, (8, 8), 1)
    assert run_face(plan, GRID).workload.grid_fragments_post_stencil == pytest.approx(2_000, rel=0.05)
    assert np.unique(seen.triangle[:32, :32]).size == 1
