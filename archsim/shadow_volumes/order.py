"""In which order shadow volumes are submitted. [Aila04] sec. 7 leaves open what that is worth."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Order(IntEnum):
    """Names the volumes that come first; equals stay as in the scene."""

    SCENE = 0  # as the mesh has its objects
    REVERSE = 1
    NEAR_LIGHT = 2  # those of casters near the light, whose shadows are wide
    LARGE = 3  # those of casters with large bounding boxes


def ranks(order: Order, box: np.ndarray, light: np.ndarray) -> np.ndarray:
    """int64 [num_volumes]: the volumes, numbered as in the scene, as they are submitted. box: see Volumes."""
    numbers = np.arange(len(box))
    if order == Order.REVERSE:
        return numbers[::-1].copy()
    if order == Order.NEAR_LIGHT:
        return np.argsort(np.linalg.norm(box.mean(axis=1) - light, axis=1), kind="stable")
    if order == Order.LARGE:
        return np.argsort(-np.linalg.norm(box[:, 1] - box[:, 0], axis=1), kind="stable")
    return numbers


def picked(starts: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(rows int64 [n], starts int64 [len(chosen) + 1]) of chosen groups; group k has the rows from starts[k] on."""
    sizes = np.diff(starts)[chosen]
    ends = np.cumsum(sizes)
    rows = np.repeat(starts[:-1][chosen] - (ends - sizes), sizes) + np.arange(sizes.sum())
    return rows, np.concatenate([[0], ends])
