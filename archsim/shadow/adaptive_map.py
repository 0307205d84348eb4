"""Adaptive shadow maps: a tree of pages, refined where samples see shadow edges too coarsely. [Fernando01]

A page is a square of texels. At first one page covers a light view; refining a page puts four pages of half the texel
size in its place. The page whose texels leave most samples in doubt is refined next: a sample is in doubt where
the 3 x 3 texels around it do not agree.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from archsim.shadow.shadow_map import Lookup, Receivers, ShadowMap, Surfaces, shadowed

PAGE_TEXELS = 32  # on a side


class Level(NamedTuple):
    """What one resolution, half the texel size of the level before, says of every sample."""

    page: np.ndarray  # int64 [n] page that the sample lies in, row by row; -1 where there is no sample
    pages_wide: int
    shadowed: np.ndarray  # float32 [n]
    doubts: np.ndarray  # int64 [pages] samples in doubt


class Refined(NamedTuple):
    """The map at some size."""

    num_texels: int
    shadowed: np.ndarray  # float32 [n], from the finest page at each sample


Rendered = tuple[ShadowMap, Surfaces, Receivers]


def levels(render_at: Callable[[int], Rendered], num_levels: int, lookup: Lookup) -> list[Level]:
    """The levels of a light view; `render_at` gives a map of so many texels on a side, and its receivers."""
    return [
        _level(PAGE_TEXELS << level, render_at(PAGE_TEXELS << level), lookup) for level in range(num_levels)
    ]


def _level(texels: int, rendered: Rendered, lookup: Lookup) -> Level:
    shadow_map, surfaces, receivers = rendered
    pages_wide = texels // PAGE_TEXELS
    place = np.clip(np.nan_to_num(receivers.position[:, :2], nan=-1.0) // PAGE_TEXELS, 0, pages_wide - 1)
    there = ~np.isnan(receivers.position[:, 0])
    page = np.where(there, place[:, 1] * pages_wide + place[:, 0], -1).astype(np.int64)
    around = shadowed(shadow_map, surfaces, receivers, lookup._replace(radius=1))
    doubtful = page[there & (around > 0) & (around < 1)]
    found = shadowed(shadow_map, surfaces, receivers, lookup)
    return Level(page, pages_wide, found, np.bincount(doubtful, minlength=pages_wide * pages_wide))


def refine(found: Sequence[Level], budgets: Sequence[int]) -> Iterator[Refined]:
    """The map after every budget of texels, smallest first: as many refinements as fit, most doubts first."""
    level_of = np.zeros(len(found[0].page), np.int64)
    num_texels = PAGE_TEXELS * PAGE_TEXELS
    waiting = [(-int(found[0].doubts[0]), 0, 0)]  # (doubts, level, page)
    members = _members(found)
    for budget in budgets:
        while waiting and num_texels + 3 * PAGE_TEXELS**2 <= budget:
            doubts, level, page = heapq.heappop(waiting)
            if level + 1 == len(found) or doubts == 0:
                continue
            num_texels += 3 * PAGE_TEXELS**2
            level_of[members(level, page)] = level + 1
            for child in _children(page, found[level].pages_wide):
                heapq.heappush(waiting, (-int(found[level + 1].doubts[child]), level + 1, child))
        stack = np.stack([level.shadowed for level in found])
        yield Refined(num_texels, np.take_along_axis(stack, level_of[None], axis=0)[0])


def _children(page: int, pages_wide: int) -> list[int]:
    """The four pages of the next level that cover a page."""
    row, column = divmod(page, pages_wide)
    return [(2 * row + j) * 2 * pages_wide + 2 * column + i for j in (0, 1) for i in (0, 1)]


def _members(found: Sequence[Level]) -> Callable[[int, int], np.ndarray]:
    """Samples of a level's page."""
    orders = [np.argsort(level.page, kind="stable") for level in found]
    starts = [
        np.searchsorted(level.page[order], np.arange(level.pages_wide**2 + 1))
        for level, order in zip(found, orders, strict=True)
    ]

    def members(level: int, page: int) -> np.ndarray:
        return orders[level][starts[level][page] : starts[level][page + 1]]

    return members
