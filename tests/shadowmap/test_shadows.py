"""Shadows looked up in maps, at places where a map has none."""

import numpy as np
import pytest

from archsim.lograster.depth_buffer import FARTHEST
from archsim.shadowmap.allocation import needed
from archsim.shadowmap.error import AT_LIGHT
from archsim.shadowmap.families import FAMILIES, make_maps
from archsim.shadowmap.picture import Picture, aliasing
from archsim.shadowmap.shadows import shadow_image
from archsim.shadowmap.view import point_light, volume_samples

from .views import view_of


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_a_surface_at_the_light_itself_is_lit_and_has_no_texel(family):
    """Three surfaces face the light: the first holds it, the last is behind what the maps hold."""
    view, place = view_of(20), np.array([0.2, 5.0, 0.5])
    maps = make_maps(family, view, point_light(place))
    points = place + [[0, 0, 0], [0, 3, 0], [0, 9, 0]]
    picture = Picture(np.ones((1, 3), bool), points, np.tile([0.0, -1, 0], (3, 1)))
    depths = [np.full((8, 8), FARTHEST // 2, np.int32) for _ in maps]

    shadow = shadow_image(maps, depths, view, picture)
    errors = aliasing(maps, [(8, 8)] * len(maps), view, picture)

    assert not shadow[0, 0]
    assert shadow[0, 2]
    assert (errors.owner == AT_LIGHT).tolist() == [True, False, False]
    assert errors.error[0] == 0 < errors.error[1]


def test_a_light_at_a_sample_of_the_view_needs_no_texels_there():
    view = view_of(20)
    light = point_light(volume_samples(view)[5000])

    assert np.isfinite(needed(make_maps("logpsm", view, light), view, 512)).all()
