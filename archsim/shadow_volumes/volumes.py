"""Shadow volumes: light cap, dark cap and side quads of every shadow-casting object.

Points are homogeneous, so that a volume can reach to infinity: the dark point of a vertex v is the direction
(v - light, 0), or, where the light has an attenuation range, the point at that distance from the light.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.scene.camera import Camera, camera_axes, to_view_space, view_window
from archsim.scene.scene import Scene
from archsim.shadow_volumes.casters import Casters, Grouping, find_casters
from archsim.shadow_volumes.order import Order, picked, ranks
from archsim.shadow_volumes.silhouette import light_cap, silhouette


class Counting(IntEnum):
    """Which fragments of shadow volumes change the stencil."""

    Z_FAIL = 0  # those behind what the pixel shows: right for every view
    ADAPTIVE = 1  # Z-pass, those before it, for volumes that cannot reach the view's near plane; Z-fail for the others


class Extrusion(NamedTuple):
    """How volumes are made."""

    grouping: Grouping
    counting: Counting
    range: float | None  # distance from the light at which volumes end, in world units; None: at infinity
    order: Order = Order.SCENE


class Volumes(NamedTuple):
    """Closed shadow volumes of one light; normals point outwards."""

    points: np.ndarray  # float64 [num_points, 4] homogeneous, in the world
    triangles: np.ndarray  # int32 [num_triangles, 3] volume after volume: light cap, dark cap, sides
    starts: np.ndarray  # int64 [num_volumes + 1] first triangle of each volume
    drawn: np.ndarray  # int64 [num_volumes] first triangle that is drawn; those before it only classify tiles
    z_pass: np.ndarray  # bool [num_volumes] counted in front of what is visible, else behind it
    box: np.ndarray  # float64 [num_volumes, 2, 3] lowest and highest corner of each object's bounding box


def shadow_volumes(scene: Scene, light: np.ndarray, extrusion: Extrusion) -> Volumes:
    """The volumes of all objects of a scene for a light at `light`, float64 [3]."""
    casters = find_casters(scene.mesh, extrusion.grouping)
    box = _boxes(casters)
    z_pass = np.zeros(casters.num_casters, bool)
    if extrusion.counting == Counting.ADAPTIVE:
        z_pass = clear_of_near_plane(box, scene, light)

    points, triangles, starts, caps = extruded(casters, light, z_pass, extrusion.range)
    chosen = ranks(extrusion.order, box, light)
    rows, starts = picked(starts, chosen)
    undrawn = np.where(z_pass, caps, 0)[chosen]  # a Z-pass cap is never before what is visible
    return Volumes(points, triangles[rows], starts, starts[:-1] + undrawn, z_pass[chosen], box[chosen])


def num_drawn(volumes: Volumes) -> int:
    """Triangles that are drawn: what [Aila04] counts, whose Z-pass has no light caps."""
    return int((volumes.starts[1:] - volumes.drawn).sum())


def extruded(
    casters: Casters, light: np.ndarray, z_pass: np.ndarray, reach: float | np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """points, triangles and starts of Volumes, and int64 [num_volumes] triangles of each light cap.

    `reach`: where volumes end, from the light; [num_vertices] for each vertex.
    """
    cap = light_cap(casters, light)
    edge = silhouette(cap)
    num_vertices = len(casters.positions)
    dark = cap.triangles[:, ::-1] + num_vertices
    if reach is None:
        needed = ~z_pass[cap.caster]  # a cap at infinity is never before anything
    else:
        needed = np.ones(len(dark), bool)
    near = np.stack([edge.end, edge.start, edge.start + num_vertices], axis=1)
    far = np.stack([edge.end, edge.start + num_vertices, edge.end + num_vertices], axis=1)
    sides = np.stack([near, far], axis=1).reshape(-1, 3)

    triangles = np.concatenate([cap.triangles, dark[needed], sides])
    caster = np.concatenate([cap.caster, cap.caster[needed], np.repeat(edge.caster, 2)])
    order = np.argsort(caster, kind="stable")
    starts = np.searchsorted(caster[order], np.arange(casters.num_casters + 1))
    caps = np.bincount(cap.caster, minlength=casters.num_casters)
    return _points(casters.positions, light, reach), triangles[order].astype(np.int32), starts, caps


def seen_by(points: np.ndarray, camera: Camera, width: int, height: int) -> np.ndarray:
    """Homogeneous points in the view: float64 [n, 4] (x z, y z, z, w) with x, y in pixels; pixel centres are whole."""
    right, up, forward = camera_axes(camera)
    at_infinity = points[:, 3] == 0
    place = to_view_space(points[:, :3], camera)
    x, y, z = points[:, :3].T
    for axis, row in enumerate((right, up, forward)):
        place[at_infinity, axis] = (x * row[0] + y * row[1] + z * row[2])[at_infinity]

    window = view_window(camera, width, height)
    across = (place[:, 0] - window.left * place[:, 2]) / window.step_x
    down = (place[:, 1] - window.top * place[:, 2]) / window.step_y
    return np.stack([across, down, place[:, 2], points[:, 3]], axis=1)


def clear_of_near_plane(box: np.ndarray, scene: Scene, light: np.ndarray) -> np.ndarray:
    """bool [n]: no point between the eye and the view's near plane can be in the shadow of what the box holds.

    True where a plane separates the box from the hull of eye, near rectangle and light.
    """
    hull, normals = _near_pyramid(scene, light)
    corners = box_corners(box)
    clear = np.zeros(len(box), bool)
    for normal in np.concatenate([np.eye(3), normals]):
        ours, theirs = corners @ normal, hull @ normal
        slack = 1e-9 * (np.abs(theirs).max() + np.abs(ours).max(initial=0.0))
        clear |= (ours.min(axis=1) > theirs.max() + slack) | (ours.max(axis=1) < theirs.min() - slack)
    return clear


def box_corners(box: np.ndarray) -> np.ndarray:
    """float64 [n, 8, 3] of boxes [n, 2, 3]."""
    choice = np.array([[index >> axis & 1 for axis in range(3)] for index in range(8)])
    return box[:, choice, np.arange(3)]


def _near_pyramid(scene: Scene, light: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eye, corners of the near rectangle and light [6, 3], and normals [m, 3] of planes that may separate."""
    camera = scene.camera
    right, up, forward = camera_axes(camera)
    half_y = np.tan(np.radians(camera.fovy_degrees) / 2) * camera.near
    half_x = half_y * scene.width / scene.height
    eye = np.asarray(camera.eye, np.float64)
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    rectangle = [eye + camera.near * forward + sx * half_x * right + sy * half_y * up for sx, sy in signs]
    hull = np.array([eye, *rectangle, light])
    following = np.roll(rectangle, -1, axis=0)
    sides = [np.cross(np.array(rectangle) - apex, following - apex) for apex in (eye, light)]
    return hull, np.concatenate([[forward], *sides])


def _boxes(casters: Casters) -> np.ndarray:
    """Bounding boxes of the objects."""
    corners = casters.positions[casters.triangles]
    box = np.empty((casters.num_casters, 2, 3))
    if casters.num_casters:
        starts = np.searchsorted(casters.caster, np.arange(casters.num_casters))
        box[:, 0] = np.minimum.reduceat(corners.min(axis=1), starts)
        box[:, 1] = np.maximum.reduceat(corners.max(axis=1), starts)
    return box


def _points(positions: np.ndarray, light: np.ndarray, reach: float | np.ndarray | None) -> np.ndarray:
    """Homogeneous vertices, then their dark points."""
    away = positions - light
    lit = np.concatenate([positions, np.ones((len(positions), 1))], axis=1)
    if reach is None:
        dark = np.concatenate([away, np.zeros((len(positions), 1))], axis=1)
    else:
        distance = np.linalg.norm(away, axis=1)
        factor = np.maximum(reach / np.where(distance > 0, distance, 1.0), 1.0)
        dark = np.concatenate([light + away * factor[:, None], np.ones((len(positions), 1))], axis=1)
    return np.concatenate([lit, dark])
