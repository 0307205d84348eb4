"""The sets of shadow maps that [Lloyd07] compares in its figure 7, for a view and a light.

standard      one map, not warped                                        [Williams78]
lispsm        one map, warped along the view                             [Wimmer04]
csm_lispsm    the view cut at logarithmic depths, each part with lispsm  [Engel07], [Zhang06]
fp_lispsm     a map for each face of the view that light leaves through  [Kozlov04] with [Wimmer04]'s warp
logpsm        the same faces, perspective warp and logarithm             [Lloyd07] sec. 3.1
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping

import numpy as np

from archsim.errors import did_you_mean, fail
from archsim.shadowmap.cone import pieces, volume
from archsim.shadowmap.faces import face_maps
from archsim.shadowmap.fit import NO_REGION, Plane, ShadowMap, Warp, fit, on_plane, plane_across
from archsim.shadowmap.view import View, depth_of

CASCADES = 5  # of the paper's figure 7


def standard(view: View, light: np.ndarray) -> list[ShadowMap]:
    """One map over the whole view."""
    return _over_range("standard", view, light, (view.near, view.far), False, NO_REGION)


def lispsm(view: View, light: np.ndarray) -> list[ShadowMap]:
    """One map over the whole view, with the light-space perspective warp."""
    return _over_range("lispsm", view, light, (view.near, view.far), True, NO_REGION)


def csm_lispsm(view: View, light: np.ndarray) -> list[ShadowMap]:
    """CASCADES maps, of equal depth ratios; more if the light is among what it shines on."""
    depths = np.geomspace(view.near, view.far, CASCADES + 1)
    depths[-1] = view.far
    maps = []
    for index, (near, far) in enumerate(itertools.pairwise(depths.tolist())):
        along = np.array([*view.axes[2], -view.axes[2] @ view.eye])
        region = np.stack([along - [0, 0, 0, near], [0, 0, 0, far] - along])
        maps += _over_range(f"cascade {index}", view, light, (near, far), True, region)
    return maps


def fp_lispsm(view: View, light: np.ndarray) -> list[ShadowMap]:
    """A map for each face; side faces with the light-space perspective warp."""
    return face_maps(view, light, logarithmic=False)


def logpsm(view: View, light: np.ndarray) -> list[ShadowMap]:
    """A map for each face; side faces with perspective and logarithm, split where they open too wide."""
    return face_maps(view, light, logarithmic=True)


FAMILIES: Mapping[str, Callable[[View, np.ndarray], list[ShadowMap]]] = {
    "standard": standard,
    "lispsm": lispsm,
    "fp_lispsm": fp_lispsm,
    "csm_lispsm": csm_lispsm,
    "logpsm": logpsm,
}
BALANCED = ("fp_lispsm", "logpsm")  # resolution shared by error; the others give each map the same


def make_maps(family: str, view: View, light: np.ndarray) -> list[ShadowMap]:
    """The maps of one of FAMILIES."""
    if family not in FAMILIES:
        raise fail(f"there are no '{family}' shadow maps", hint=did_you_mean(family, FAMILIES))
    return FAMILIES[family](view, light)


def _over_range(
    name: str, view: View, light: np.ndarray, depths: tuple[float, float], warped: bool, region: np.ndarray
) -> list[ShadowMap]:
    """A map over the part of the view between two depths, its axis along the line of sight; several if need be."""
    maps = []
    for piece in pieces(view, light, *depths):
        plane = plane_across(piece.axis, piece.outline, view.axes[2], light)
        whole = f"{name} {piece.name}".strip()
        centre = _lispsm_centre(plane, piece.outline, view, light) if warped else None
        regions = np.concatenate([region, piece.region])
        maps.append(
            fit(whole, plane, light, piece.outline, volume(piece, light), Warp(centre, False), regions)
        )
    return maps


def _lispsm_centre(plane: Plane, points: np.ndarray, view: View, light: np.ndarray) -> float:
    """Where the perspective of [Wimmer04] has its centre: n + sqrt(n f) over the sine of light and line of sight."""
    depths = depth_of(view, points)
    near, far = max(float(depths.min()), view.near), float(depths.max())
    sine = float(np.linalg.norm(np.cross(plane.equation[:3], view.axes[2])))
    first = float(on_plane(plane, light, points)[:, 1].min())
    return first - (near + math.sqrt(near * far)) / max(sine, 1e-6)
