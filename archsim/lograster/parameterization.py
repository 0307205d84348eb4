"""The logarithmic parameterization of a shadow map and the bits that it needs. [Lloyd07] eq. 1, 2, 5, 9 to 11

`ratio` is f/n, the far over the near depth of what the map covers; 1 stands for the linear map. All of y, y'
are in [0, 1].
"""

from __future__ import annotations

import math

import numpy as np

from archsim.errors import fail

NEARLY_LINEAR = 1e-6  # below ratio - 1 = this, the map differs from the linear one by less than 2^-22


def log_warp(y: np.ndarray, ratio: float) -> np.ndarray:
    """y' = F(y) = c0 log(c1 y + 1): where a post-perspective y is stored. [Lloyd07] eq. 1, 2"""
    if ratio - 1 < NEARLY_LINEAR:
        return np.asarray(y, dtype=np.float64)
    c0, c1 = constants(ratio)
    return np.asarray(c0 * np.log1p(c1 * np.asarray(y, dtype=np.float64)))


def log_unwarp(warped: np.ndarray, ratio: float) -> np.ndarray:
    """y = G(y'), the inverse of `log_warp`. [Lloyd07] eq. 5"""
    if ratio - 1 < NEARLY_LINEAR:
        return np.asarray(warped, dtype=np.float64)
    c0, c1 = constants(ratio)
    return np.asarray(np.expm1(np.asarray(warped, dtype=np.float64) / c0) / c1)


def constants(ratio: float) -> tuple[float, float]:
    """(c0, c1) of eq. 2."""
    check_ratio(ratio)
    return -1.0 / math.log(ratio), (1.0 - ratio) / ratio


def unwarp_slope(warped: np.ndarray, ratio: float) -> np.ndarray:
    """dy / dy' = (c1 y + 1) / (c0 c1) at y = G(y'); it falls from ln(ratio) ratio / (ratio - 1) by the factor
    `ratio`.
    """
    if ratio - 1 < NEARLY_LINEAR:
        return np.ones_like(np.asarray(warped, dtype=np.float64))
    c0, c1 = constants(ratio)
    return np.asarray(np.exp(np.asarray(warped, dtype=np.float64) / c0) / (c0 * c1))


def smallest_step(num_rows: float, ratio: float) -> float:
    """The least distance of two rows in y, next to y' = 1. [Lloyd07] eq. 9: Delta G_min"""
    check_ratio(ratio)
    if ratio - 1 < NEARLY_LINEAR:
        return 1.0 / num_rows
    return math.expm1(math.log(ratio) / num_rows) / (ratio - 1.0)


def bits_needed(num_rows: float, ratio: float) -> int:
    """b_min: fraction bits that represent every two rows distinctly. [Lloyd07] eq. 9"""
    return math.ceil(-math.log2(smallest_step(num_rows, ratio)))


def bits_bound(num_rows: float, ratio: float) -> float:
    """The paper's bound on `bits_needed` before rounding up, for ratios from 1 to 1e5. [Lloyd07] eq. 10"""
    return math.log2(num_rows) + 0.8 * math.log2(ratio)


def largest_ratio(num_rows: float, bits: int = 24) -> float:
    """The largest f/n that `bits` fraction bits can handle by the bound. [Lloyd07] eq. 11"""
    return 2.0 ** ((bits - math.log2(num_rows)) / 0.8)


def check_ratio(ratio: float) -> None:
    """A ratio is a finite number of at least 1."""
    if not 1 <= ratio < math.inf:
        raise fail(f"the ratio of far to near must be at least 1, not {ratio}")
