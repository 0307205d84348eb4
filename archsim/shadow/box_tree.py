"""A tree of boxes around triangles, split by their surface ([Wald07]): what the ray tracer walks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.jit import njit
from archsim.scene.mesh import Mesh

_BOX_SLACK = 1 + 1e-14  # rounding of the box test must not lose a hit
FAR = 1e300  # beyond every hit; a missed box is entered at inf
_LEAF_TRIANGLES = 4
INNER = -1
_HALVING_DEPTH = 60  # from here down nodes are halved: a tree of 2^31 triangles is at most 60 + 31 deep
STACK = 96  # nodes that can wait while a ray walks the tree


class Tree(NamedTuple):
    """Boxes in boxes. Node n is a leaf, or INNER with the children first[n] and first[n] + 1."""

    low: np.ndarray  # float64 [num_nodes, 3]
    high: np.ndarray  # float64 [num_nodes, 3]
    first: np.ndarray  # int64 [num_nodes] first child, or first place in `order`
    number: np.ndarray  # int64 [num_nodes] triangles of a leaf, or INNER
    order: np.ndarray  # int64 [num_triangles] triangle indices, those of a leaf side by side
    corners: np.ndarray  # float64 [num_triangles, 3, 3] by triangle index


def build_tree(mesh: Mesh) -> Tree:
    """The tree of a mesh; one empty leaf for an empty mesh."""
    corners = np.asarray(mesh.vertices, dtype=np.float64)[mesh.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    order = np.arange(len(corners))
    nodes = [_Node(0, len(corners), 0)]
    boxes, firsts, counts = [], [], []
    for node in nodes:  # grows while it is walked
        part = order[node.start : node.end]
        boxes.append((low[part].min(axis=0, initial=np.inf), high[part].max(axis=0, initial=-np.inf)))
        if len(part) <= _LEAF_TRIANGLES:
            firsts.append(node.start)
            counts.append(len(part))
            continue

        middle = node.start + _split(part, low, high, node.depth)
        firsts.append(len(nodes))
        counts.append(INNER)
        nodes.append(_Node(node.start, middle, node.depth + 1))
        nodes.append(_Node(middle, node.end, node.depth + 1))
    low_high = np.array(boxes)
    return Tree(
        low_high[:, 0].copy(), low_high[:, 1].copy(), np.array(firsts), np.array(counts), order, corners
    )


class _Node(NamedTuple):
    start: int  # first place in `order`
    end: int
    depth: int  # below the root


def _split(part: np.ndarray, low: np.ndarray, high: np.ndarray, depth: int) -> int:
    """Sort triangle indices in place along the axis of greatest extent; return how many go left.

    The sum of (surface x triangles) of both sides decides; in a tree already deep half of them go.
    """
    middles = low[part] + high[part]
    axis = int(np.argmax(np.ptp(middles, axis=0)))
    part[:] = part[np.argsort(middles[:, axis], kind="stable")]
    if depth >= _HALVING_DEPTH:
        return len(part) // 2

    number = np.arange(1, len(part))
    left = _growing_surface(low[part], high[part])[:-1] * number
    right = _growing_surface(low[part][::-1], high[part][::-1])[:-1] * number
    return 1 + int(np.argmin(left + right[::-1]))


def _growing_surface(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Half the surface of the box around the first 1, 2, ... n boxes; [n]."""
    x, y, z = (np.maximum.accumulate(high) - np.minimum.accumulate(low)).T
    return np.asarray(x * y + y * z + z * x)


@njit
def push_nearer_last(tree, first, ray, stack, waiting):
    """Put the children at `first` on the stack, the one entered earlier on top; the new height."""
    origin, inverse = ray
    second_is_nearer = box_entry(tree, first + 1, origin, inverse) < box_entry(tree, first, origin, inverse)
    nearer = first + 1 if second_is_nearer else first
    stack[waiting], stack[waiting + 1] = 2 * first + 1 - nearer, nearer
    return waiting + 2


@njit
def box_entry(tree, node, origin, inverse):
    """Ray parameter >= 0 at which the ray enters the node's box; inf if it misses the box."""
    entry, leave = 0.0, np.inf
    for axis in range(3):
        one = (tree.low[node, axis] - origin[axis]) * inverse[axis]
        other = (tree.high[node, axis] - origin[axis]) * inverse[axis]
        entry = max(entry, min(one, other))
        leave = min(leave, max(one, other))
    return entry if entry <= leave * _BOX_SLACK else np.inf
