"""What an irregular shadow map computes, time apart: light views checked against the plain algorithm, the picture."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, reduce
from typing import NamedTuple

import numpy as np

from archsim.execute import izb_memory
from archsim.execute.izb_memory import Structure
from archsim.run.izb_figures import (
    cell_map,
    fragment_histogram,
    fragments_of_samples,
    list_histogram,
    visits_of_samples,
)
from archsim.run.izb_statistics import picture_statistics, workload_statistics
from archsim.run.izb_subject import Subject
from archsim.run.izb_work import LightViewWork
from archsim.run.result import Check, Histogram, Statistic
from archsim.shadow import izb
from archsim.shadow.grid import Grid
from archsim.shadow.pixel_tiles import untile
from archsim.shadow.plain import FacePlan, Outcome, run_face
from archsim.shadow.workload import NOTHING, IzbWorkload, combined

_FRAGMENT, _NODE, _HIT = 5, 7, 2  # instructions of izb_raster.s for a grid fragment, a node visited, a hit


class Emitted(NamedTuple):
    """Framebuffer fragments as they come."""

    samples: list[np.ndarray]
    depths: list[np.ndarray]

    def take(self, samples: np.ndarray, depths: np.ndarray) -> None:
        self.samples.append(samples.astype(np.int32))
        self.depths.append(depths)

    def all(self) -> tuple[np.ndarray, np.ndarray]:
        if not self.samples:
            return np.empty(0, np.int32), np.empty(0, np.float32)
        return np.concatenate(self.samples), np.concatenate(self.depths)


class ViewLaws(NamedTuple):
    """What a light view's phases must agree with, whatever machine plays them."""

    checks: list[Check]  # that the kernels did what the plain algorithm does
    raster_instructions: int | None  # that `izb_raster.s` takes for what the plain algorithm counts
    num_fragments: int  # framebuffer fragments that the kernel emitted


class ViewFound(NamedTuple):
    """One light view, computed."""

    laws: ViewLaws
    outcome: Outcome  # the plain algorithm's
    shadow: np.ndarray  # bool [num_samples] in tile order


class Picture(NamedTuple):
    """All light views together."""

    scene_digest: str
    workload: IzbWorkload
    statistics: list[Statistic]  # of the workload and of what is seen
    shadow: np.ndarray  # as in Result
    histograms: list[Histogram]
    maps: dict[str, np.ndarray]


def find(view: LightViewWork, emitted: Emitted) -> ViewFound:
    """The light view by the plain algorithm, beside what the kernels made, when both phases are drawn to their end."""
    expected = run_face(view.plan, view.grid, _sample_order(view.plan, view.tiles))
    samples, depths = emitted.all()
    tested = izb.z_test_fragments(izb.z_test(expected.samples), samples, depths)
    trees = view.memory.storage.structure == Structure.KD_TREE
    same_lists = _same_trees(view, expected) if trees else _same_lists(view, expected)
    same_fragments = _same_fragments((samples, depths), expected, any_order=trees)
    laws = ViewLaws(
        [
            Check("build kernel = plain algorithm", same_lists, "nodes, lists, stencil"),
            Check("raster kernel = plain algorithm", same_fragments, "fragments in order"),
        ],
        None if trees else _explained(expected.workload),
        len(samples),
    )
    return ViewFound(laws, expected, izb.in_shadow(tested, expected.samples))


def compose(subject: Subject, views: list[LightViewWork], found: list[ViewFound]) -> Picture:
    """The picture of all light views."""
    outcomes = [each.outcome for each in found]
    workload = reduce(combined, (outcome.workload for outcome in outcomes), NOTHING)
    shadow = _shadow(subject, found)
    maps = {
        "Framebuffer fragments of each pixel [fragments]": _spread(subject, outcomes, fragments_of_samples)
    }
    histograms = [fragment_histogram(outcomes)]
    if views and views[0].memory.storage.structure != Structure.KD_TREE:
        cost = partial(_instructions_of_samples, views[0].grid)
        maps["Issue cycles of the raster kernel on each pixel [cycles]"] = _spread(subject, outcomes, cost)
    if views:
        maps["Samples in each logical cell, first light view [samples]"] = cell_map(
            outcomes[0], views[0].grid
        )
        histograms.insert(0, list_histogram(outcomes, views[0].grid))
    statistics = [*workload_statistics(workload, len(views)), *picture_statistics(subject.seen, shadow)]
    return Picture(subject.digest, workload, statistics, shadow, histograms, maps)


def _explained(workload: IzbWorkload) -> int:
    """Instructions of the raster kernel."""
    hits = workload.framebuffer_fragments_pre_z
    return _FRAGMENT * workload.grid_fragments_post_stencil + _NODE * workload.node_visits + _HIT * hits


def _instructions_of_samples(grid: Grid, outcome: Outcome) -> np.ndarray:
    """int64 [num_samples] instructions of the raster kernel on the sample's node."""
    return _NODE * visits_of_samples(outcome, grid) + _HIT * fragments_of_samples(outcome)


def _sample_order(plan: FacePlan, tiles: np.ndarray) -> np.ndarray:
    """Samples in the order in which the build kernel inserts them."""
    per_tile = plan.tiles.num_pairs * 2
    return (tiles[:, None] * per_tile + np.arange(per_tile)).ravel()


def _same_lists(view: LightViewWork, expected: Outcome) -> bool:
    """Whether nodes, heads and stencil in memory are what the plain algorithm makes, to the bit."""
    memory, placed = view.memory, expected.samples.cell[:, 0] >= 0
    nodes = izb_memory.nodes(memory)[placed, :3]
    return bool(
        np.array_equal(nodes.view(np.int32), expected.samples.position[placed].view(np.int32))
        and np.array_equal(izb_memory.heads(memory, view.grid), expected.lists.head)
        and np.array_equal(izb_memory.following(memory)[placed], expected.lists.following[placed])
        and np.array_equal(izb_memory.stencil(memory, view.grid), expected.lists.stencil)
    )


def _same_trees(view: LightViewWork, expected: Outcome) -> bool:
    """Whether every cell with samples has a tree and every sample a node; how they hang together is not asked."""
    memory, placed = view.memory, expected.samples.cell[:, 0] >= 0
    nodes = np.abs(izb_memory.nodes(memory)[placed, :2])
    return bool(
        np.array_equal(nodes.view(np.int32), expected.samples.position[placed, :2].view(np.int32))
        and np.array_equal(izb_memory.heads(memory, view.grid) >= 0, expected.lists.head >= 0)
        and np.array_equal(izb_memory.stencil(memory, view.grid), expected.lists.stencil)
    )


def _same_fragments(emitted: tuple[np.ndarray, np.ndarray], expected: Outcome, any_order: bool) -> bool:
    """Whether the kernel emitted what the plain algorithm finds, to the bit; grid fragment after grid fragment."""
    samples, depths, fragments = *emitted, expected.fragments
    if len(samples) != len(fragments.sample):
        return False
    if any_order:
        owner = np.repeat(np.arange(len(fragments.starts) - 1), np.diff(fragments.starts))
        order = np.lexsort((samples, owner))
        samples, depths = samples[order], depths[order]
        order = np.lexsort((fragments.sample, owner))
        fragments = fragments._replace(sample=fragments.sample[order], depth=fragments.depth[order])
    return bool(
        np.array_equal(samples, fragments.sample)
        and np.array_equal(depths.view(np.int32), fragments.depth.view(np.int32))
    )


def _shadow(subject: Subject, found: list[ViewFound]) -> np.ndarray:
    """The shadow mask of all light views."""
    size = subject.seen.triangle.shape
    shadow = np.zeros(size, np.bool_)
    for plan, face in zip(subject.plans, found, strict=True):
        shadow |= untile(plan.tiles, face.shadow, *size)
    return shadow


def _spread(
    subject: Subject, outcomes: list[Outcome], of_samples: Callable[[Outcome], np.ndarray]
) -> np.ndarray:
    """float32 [height, width]: what is counted of each pixel's sample, NaN where there is none."""
    size = subject.seen.triangle.shape
    image = np.full(size, np.nan, np.float32)
    for plan, outcome in zip(subject.plans, outcomes, strict=True):
        counts = untile(plan.tiles, of_samples(outcome), *size)
        image[plan.face.taken] = counts[plan.face.taken]
    return image
