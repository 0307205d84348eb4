"""Maps hold what they serve, everything is served, and light rays are points of the map."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.errors import ArchsimError
from archsim.shadowmap import faces as shadowmap_faces
from archsim.shadowmap.cone import NEAREST
from archsim.shadowmap.error import AT_LIGHT, owner, places, serves
from archsim.shadowmap.faces import faces
from archsim.shadowmap.families import CASCADES, FAMILIES, make_maps
from archsim.shadowmap.fit import with_one
from archsim.shadowmap.view import (
    at_depth,
    depth_of,
    directional_light,
    make_view,
    point_light,
    volume_samples,
)

from .views import ALONG_Y, DIRECTIONS, OVERHEAD, POINTS_INSIDE, view_of

POINTS = volume_samples(view_of(20), 5, 9)


def check_service(family, light):
    """Every point of the view is in the region of a map, and inside that map unless it is the light itself."""
    maps = make_maps(family, view_of(20), light)
    served = np.stack([serves(shadow_map, POINTS) for shadow_map in maps])
    assert served.any(axis=0).all()
    owners = owner(maps, POINTS)
    from_light = np.linalg.norm(light[:3] - light[3] * POINTS, axis=1)
    assert (from_light[owners == AT_LIGHT] < 1e-5).all()
    for index, shadow_map in enumerate(maps):
        mine = POINTS[owners == index]
        image = with_one(mine) @ shadow_map.matrix.T
        assert (image[:, 3] > 0).all()
        here = places(shadow_map, mine)
        for coordinate in (here.x, here.y):
            assert coordinate.min(initial=0.0) > -1e-6
            assert coordinate.max(initial=1.0) < 1 + 1e-6


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(sorted(FAMILIES)), DIRECTIONS)
def test_directional_lights_reach_every_point_of_the_view(family, light):
    check_service(family, light)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(sorted(FAMILIES)), POINTS_INSIDE)
def test_every_family_serves_lights_inside_the_view(family, light):
    check_service(family, light)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(sorted(FAMILIES)), DIRECTIONS, st.floats(0.1, 5))
def test_a_light_ray_is_one_place_and_depth_falls_towards_the_light(family, light, step):
    for shadow_map in make_maps(family, view_of(20), light):
        mine = POINTS[serves(shadow_map, POINTS)]
        nearer = mine + step * light[:3]
        one, other = places(shadow_map, mine), places(shadow_map, nearer)
        assert one.x == pytest.approx(other.x, abs=1e-6)
        assert one.y == pytest.approx(other.y, abs=1e-6)
        depths = [
            with_one(p) @ shadow_map.matrix[2] / (with_one(p) @ shadow_map.matrix[3]) for p in (mine, nearer)
        ]
        assert (depths[1] < depths[0]).all()


@pytest.mark.parametrize("ratio", [10, 1000])
def test_logarithmic_maps_space_depth_evenly_on_the_side_faces(ratio):
    """y' = ln(z/n) / ln(f/n) on the face itself, and x fills the map everywhere."""
    view = view_of(ratio)
    for face in faces(view)[:4]:
        outward = directional_light(view.eye + view.axes[2] * 3 - face.corners.mean(axis=0) / ratio)
        for shadow_map in make_maps("logpsm", view, outward):
            if shadow_map.name != face.name:
                continue
            parts = np.linspace(0, 1, 9)[:, None]
            for near, far, x in ((0, 3, 0.0), (1, 2, 1.0)):
                line = face.corners[near] + parts * (face.corners[far] - face.corners[near])
                here = places(shadow_map, line)
                assert here.y == pytest.approx(np.log(depth_of(view, line)) / np.log(ratio), abs=1e-6)
                assert abs(here.x - x).max() < 1e-6 or abs(here.x - (1 - x)).max() < 1e-6


def test_figure_7_has_three_maps_from_faces():
    """A light from behind and above to one side: two sides and the far end. The paper's figure has three,
    too.
    """
    light = directional_light(np.array([0.5, -0.6, 1.0]))

    assert [m.name for m in make_maps("logpsm", view_of(1000), light)] == ["left", "bottom", "far"]
    assert len(make_maps("csm_lispsm", view_of(1000), light)) == 5
    assert len(make_maps("standard", view_of(1000), light)) == 1


def test_a_light_inside_the_view_leaves_through_all_six_faces():
    light = np.array([0.2, 5.0, 0.5, 1.0])

    assert len(make_maps("fp_lispsm", view_of(20), light)) == 6
    assert {m.name.split()[0] for m in make_maps("logpsm", view_of(20), light)} == {
        f.name for f in faces(view_of(20))
    }


def check_depths(family, light):
    """What is 2 % of the way from a light, and more, has its depth; nothing is beyond all depths."""
    maps = make_maps(family, view_of(20), light)
    owners = owner(maps, POINTS)
    from_light = np.linalg.norm(light[:3] - POINTS, axis=1)
    reaches = from_light > 2 * NEAREST * from_light.max()  # at most 60 degrees from the axis of depths
    for index, shadow_map in enumerate(maps):
        mine = owners == index
        depth, weight = shadow_map.matrix[2:] @ with_one(POINTS).T
        assert (depth[mine] < (1 + 1e-6) * weight[mine]).all()
        assert (depth[mine & reaches] > -1e-6 * weight[mine & reaches]).all()


POINTS_ANYWHERE = st.tuples(*[st.floats(-30, 30)] * 3).map(lambda p: np.array([*p, 1.0]))


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(["standard", "lispsm", "csm_lispsm"]), POINTS_ANYWHERE)
def test_families_without_faces_serve_lights_wherever_they_are(family, light):
    check_service(family, light)
    check_depths(family, light)


CORNER = at_depth(view_of(20), np.array(-1.0), np.array(1.0), np.array(20.0))
LIGHTS_ON_THE_VIEW = {
    "in the middle of the near end": [0, 1, 0],
    "on the near end": [0, 1, 0.375],
    "on the near end, elsewhere": [0, 1, 0.5],
    "in the middle of the far end": [0, 20, 0],
    "on an edge": [0, 1, math.tan(math.radians(30))],
    "on a side": POINTS[40],
    "on a corner": CORNER,
    "just outside a corner": CORNER + [-1e-9, 0, 0],
    "just outside the near end": [1e-8, 1 - 1e-9, 0],
    "just inside the near end": [0, 1 + 1e-9, 0],
    "at the eye": [0, 0, 0],
    "nearer to a point than numbers tell": [5e-324, 1, 0],
}


@pytest.mark.parametrize("light", LIGHTS_ON_THE_VIEW.values(), ids=LIGHTS_ON_THE_VIEW)
@pytest.mark.parametrize("family", ["standard", "lispsm", "csm_lispsm"])
def test_families_without_faces_serve_lights_on_what_bounds_the_view(family, light):
    check_service(family, point_light(light))
    check_depths(family, point_light(light))


def test_a_face_is_not_served_by_a_light_in_its_middle():
    """No light leaves through it."""
    check_service("logpsm", point_light([0, 20, 0]))
    assert "far" not in {m.name for m in make_maps("logpsm", view_of(20), point_light([0, 20, 0]))}


@pytest.mark.parametrize(("widest", "sun", "lamp"), [(180.1, 3.0, 6.0), (90.0, 3.3, 9.7), (52.0, 4.0, 9.9)])
def test_no_angle_of_splitting_gives_both_of_the_papers_mean_numbers_of_maps(monkeypatch, widest, sun, lamp):
    """[Lloyd07] sec. 3.2 has about 4 maps for directional lights and 6 for point lights in the view: six is one a
    face, none split; four takes faces that are split from 52 degrees on.
    """
    monkeypatch.setattr(shadowmap_faces, "WIDEST_DEGREES", widest)
    random = np.random.default_rng(0)
    view = view_of(1000)
    suns = [directional_light(random.normal(size=3)) for _ in range(150)]
    depths = 1000 ** random.uniform(0.1, 0.9, 60)
    lamps = [
        np.array([*at_depth(view, *random.uniform(-0.9, 0.9, 2), np.array(depth)), 1.0]) for depth in depths
    ]

    means = [np.mean([len(make_maps("logpsm", view, light)) for light in lights]) for lights in (suns, lamps)]

    assert means == pytest.approx([sun, lamp], abs=0.25)


def test_a_light_inside_the_view_takes_a_cube_and_many_more_cascades():
    """[Lloyd07] sec. 3.2: "for omnidirectional point lights, multiple sets of CSMs are required"."""
    light = np.array([0.2, 5.0, 0.5, 1.0])

    assert len(make_maps("standard", view_of(20), light)) == 6
    assert len(make_maps("csm_lispsm", view_of(20), light)) > 2 * CASCADES


def test_wide_side_faces_are_split():
    """A wide view from just above: the bottom face's edges open by more than a right angle."""
    wide = make_view(ALONG_Y._replace(fovy_degrees=100.0), 1.5, 100.0)
    names = [m.name for m in make_maps("logpsm", wide, OVERHEAD)]

    assert {"bottom 1", "bottom 2"} <= set(names)


def test_lispsm_becomes_standard_when_the_light_shines_along_the_view():
    light = directional_light(np.array([0.0, -1.0, 1e-7]))
    warped, plain = make_maps("lispsm", view_of(100), light)[0], make_maps("standard", view_of(100), light)[0]
    points = volume_samples(view_of(100), 5, 5)

    assert places(warped, points).y == pytest.approx(places(plain, points).y, abs=1e-3)


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda: make_maps("logpms", view_of(20), OVERHEAD), "did you mean 'logpsm'"),
        (lambda: directional_light(np.zeros(3)), "must not be zero"),
        (lambda: view_of(0.5), "0 < near < far"),
    ],
)
def test_what_cannot_be_is_said(make, what):
    with pytest.raises(ArchsimError, match=what):
        make()
