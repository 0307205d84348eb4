"""Does the order of triangles, or of the fragments within one, explain the raster phase's stalls? As Markdown.

Run: python experiments/johnson2004/orders.py [ROW ...]      (default: the three scenes)

Samples, lists and machine stay as configured; the same grid fragments are played in other orders, once with list heads
of 16 bytes, once of 4. At last, other fragments: those that a stencil of physical cells lets pass.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np
from sensitivity import PHASES, load_row, played, printed

from archsim.execute import izb_memory
from archsim.execute.izb_raster import raster_work
from archsim.raster.conservative import GridFragments, populated
from archsim.run.izb_subject import subject_of
from archsim.run.izb_work import LightViewWork, Recorded, prepare, takes
from archsim.shadow.grid import Grid, head_of_logical
from archsim.shadow.plain import grid_fragments

ROWS = ("doom_light0", "doom_light1", "knot_light0")
HEADS = (16, 4)  # bytes
RUN = 100  # triangles of a draw call
SQUARE = 16  # cells
SEED = 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", nargs="*", default=ROWS)
    options = parser.parse_args()
    heads = " | ".join(f"cycles a sample, heads of {head} bytes | useful %" for head in HEADS)
    print(f"| row | order | {heads} |")
    print("|---|---|" + "---|---|" * len(HEADS))
    for row in options.rows:
        show_row(row)


def show_row(row: str) -> None:
    """All orders of one scene."""
    raster = printed(row)[1]
    print(f"| {row} | *printed* | {raster['cycles_per_tri_sample']} | {raster['useful_percent']} | | |")
    views = [built(row, head) for head in HEADS]
    found = [fragments_of(view) for view in views]
    for name, order in orders(views[0], found[0]):
        cells = [show_order(row, view, taken(each, order)) for view, each in zip(views, found, strict=True)]
        print(f"| {row} | {name} | " + " | ".join(cells) + " |", flush=True)
    cells = [show_order(row, view, behind_physical_stencil(view)) for view in views]
    print(f"| {row} | other fragments: a stencil of physical cells | " + " | ".join(cells) + " |", flush=True)


def built(row: str, head_bytes: int) -> LightViewWork:
    """The light view of a row, its lists in memory."""
    config = load_row(row, [f"workload.head_bytes={head_bytes}"])
    (view,) = prepare(config.workload, takes(config), subject_of(config))
    for _ in view.build().chunks:
        pass
    return view


def fragments_of(view: LightViewWork) -> GridFragments:
    """Grid fragments as the rasterizer makes them: triangle by triangle, tile by tile of 8 x 8 cells."""
    return grid_fragments(view.plan, izb_memory.stencil(view.memory, view.grid), view.grid)


def behind_physical_stencil(view: LightViewWork) -> GridFragments:
    """Grid fragments if the stencil lets cells pass whose physical cell has a list ([Johnson04] sec. 6)."""
    logical, heads = izb_memory.stencil(view.memory, view.grid), izb_memory.heads(view.memory, view.grid)
    return grid_fragments(view.plan, physical_stencil(logical, heads, view.grid), view.grid)


def physical_stencil(logical: np.ndarray, heads: np.ndarray, grid: Grid) -> np.ndarray:
    """bool like `logical`: whether the list of a cell's physical cell holds a sample, within the box of the samples."""
    box, marked = populated(logical), np.zeros_like(logical)
    for j in range(box.j0, box.j1):
        for i in range(box.i0, box.i1):
            marked[j, i] = heads[head_of_logical(grid, i, j)] >= 0
    return marked


def orders(view: LightViewWork, found: GridFragments) -> Iterator[tuple[str, np.ndarray]]:
    """(name, positions in `found` in the order of playing)."""
    rng = np.random.default_rng(SEED)
    bounds = view.plan.occluders.setup.bounds
    number, triangle, i, j = np.arange(len(bounds)), found.setup_index, found.i, found.j
    calls = rng.permutation(len(bounds) // RUN + 1)[number // RUN]
    yield "as configured", np.arange(len(i))
    yield "triangles backwards", _by(-number[triangle])
    yield "triangles in random order", _by(rng.permutation(number)[triangle])
    yield f"runs of {RUN} triangles in random order", _by(calls[triangle])
    yield (
        f"triangles along a Z-order curve of {SQUARE} x {SQUARE} cells",
        _by(z_order(bounds, SQUARE)[triangle]),
    )
    yield "cells of a triangle in scan lines", np.lexsort((i, j, triangle))
    yield "cells of a triangle in tiles of 4 x 4", np.lexsort((i, j, i // 4, j // 4, triangle))
    yield "cells of a triangle in tiles of 16 x 16", np.lexsort((i, j, i // 16, j // 16, triangle))
    yield "cells of a triangle in random order", np.lexsort((rng.random(len(i)), triangle))
    yield "all fragments of a cell together, tile by tile", np.lexsort((triangle, i, j, i // 8, j // 8))


def _by(key: np.ndarray) -> np.ndarray:
    return np.argsort(key, kind="stable")


def z_order(bounds: np.ndarray, square: int) -> np.ndarray:
    """int64 [n] place along a Z-order curve of the square of cells that the middle of some bounds lies in."""
    low, high = (np.clip(side, 0, 4095) for side in (bounds[:, :2], bounds[:, 2:]))
    place = ((low + high) / 2 // square).astype(np.int64)
    bits = [(place[:, axis] >> bit & 1) << (2 * bit + axis) for axis in (0, 1) for bit in range(12)]
    return np.sum(bits, axis=0)


def taken(found: GridFragments, order: np.ndarray) -> GridFragments:
    return found._replace(setup_index=found.setup_index[order], i=found.i[order], j=found.j[order])


def show_order(row: str, view: LightViewWork, cells: GridFragments) -> str:
    """Two columns of the table."""
    work = raster_work(view.memory, view.grid, view.plan.occluders, cells, lambda samples, depths: None)
    recorded = Recorded([], [], list(work.chunks), view.for_threads, view.needed_bytes)
    spec, counters = played(load_row(row), recorded, PHASES[1])
    useful = 100 * counters.useful.sum() / (counters.cycles * spec.core.num_cores)
    return f"{counters.cycles / counters.emitted.sum():.2f} | {useful:.1f}"


if __name__ == "__main__":
    main()
