"""Table 1 of Aila, Akenine-Moller 2004, A Hierarchical Shadow Volume Algorithm.

What the paper prints is in `experiments/aila2004/printed.yaml`; no simulation reads it. Views were searched on the
brute-force column: `experiments/aila2004/calibrate.py`. What else was chosen knowing a number of the table is in
`experiments/aila2004/README.md`, and CHOSEN names its cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from archsim import resources
from archsim.config import load_walkthrough_with_origins
from archsim.reproduce.cells import (
    CALIBRATED,
    NOT_COMPARABLE,
    PREDICTED,
    Cell,
    Paper,
    Place,
    make_cell,
)
from archsim.reproduce.reproduction import Reproduction, Row
from archsim.reproduce.rows import simulate_file, simulate_rows
from archsim.run.progress import Progress, silent
from archsim.run.result import Result
from archsim.run.walkthrough import simulate_walkthrough

ID = "aila2004"
ROWS = ("powerplant", "knights", "amphitheater", "simple")
VARIANTS = {"BF": "brute_force", "DB": "depth_bounds", "H": "hierarchical"}
MB = 2**20
QUANTITIES = {  # of the printed table: what it is called here, and its unit
    "stencil_shadow_MB": ("stencil_shadow", MB, "MB"),
    "z_shadow_MB": ("depth_shadow", MB, "MB"),
    "stencil_lighting_MB": ("stencil_lighting", MB, "MB"),
    "psv_MB": ("psv", MB, "MB"),
    "delay_stream_MB": ("delay_stream", MB, "MB"),
    "total_MB": ("total", MB, "MB"),
    "pixels_M": ("processed", 10**6, "million"),
}
CLAIMS = {  # printed range: (quantity, variant that is compared with)
    "bandwidth_reduction_vs_bf": ("total", "brute_force"),
    "bandwidth_reduction_vs_db": ("total", "depth_bounds"),
    "pixel_reduction_vs_bf": ("processed", "brute_force"),
    "pixel_reduction_vs_db": ("processed", "depth_bounds"),
}
CHOSEN = {("knights", "DB"), ("amphitheater", "DB")}  # columns that a choice about the scene was made knowing
LEAST_DIGITS = 0.01  # MB: smaller printed numbers have one digit, and stand for a range as wide as themselves
PAPER = Paper(
    id=ID,
    title="Aila, Akenine-Moller 2004: A Hierarchical Shadow Volume Algorithm",
    tables={
        1: "Bandwidth and pixels of an average frame: brute force (BF), depth bounds (DB), hierarchical (H)",
        2: "Ranges that the text claims for the hierarchical algorithm",
    },
    notes={
        1: [
            "The scenes are stand-ins. Camera, light and sizes were searched so that the number of triangles and the "
            "brute-force column come near the paper's.",
            "Depth bounds (DB) of Knights and Amphitheater count as calibrated: the knights' eye is three units or "
            "more from their middle, of two equally good walkthroughs the one with the nearer DB was taken, and the "
            "amphitheater's columns are one object, knowing that column. No number of the hierarchical column (H) was "
            "aimed at.",
            "2 bytes a stencil operation on a pixel, 128 bytes a tile of compressed depths, 1 byte a lit pixel or 64 "
            "bytes a tile that is not lit or shadowed as a whole: counted, not computed from each other.",
            "The delay stream's vertex history and the PSV cache's line and ways are not printed.",
            "Numbers printed with one digit below 0.01 MB are not compared.",
        ],
        2: ["Errors are 0 inside the printed range, which is the range over the paper's four scenes."],
    },
)


def reproduce(
    progress: Progress = silent, folder: Path | None = None, overrides: Sequence[str] = ()
) -> Reproduction:
    """Draw the four walkthroughs, two at a time, and set up the tables.

    Frames are kept in `folder` as they are drawn, and not drawn again when they are there.
    """
    rows = simulate_rows(ROWS, partial(simulate_row, folder, tuple(overrides)), progress)
    return Reproduction(rows, make_cells(rows))


def simulate_row(folder: Path | None, overrides: Sequence[str], name: str, progress: Progress) -> Row:
    """Draw one walkthrough, at full size where nothing is overridden."""
    simulate = partial(simulate_walkthrough, folder=folder)
    return simulate_file(ID, name, load_walkthrough_with_origins, simulate, progress, overrides)


def make_cells(rows: dict[str, Row]) -> list[Cell]:
    """The cells of both tables."""
    printed = yaml.safe_load((resources.experiment(ID) / "printed.yaml").read_text(encoding="utf-8"))
    cells = []
    for name, row in rows.items():
        cells += _table_cells(name, row.result, printed)
        cells += _claim_cells(name, row.result, printed["claims"])
    return sorted(cells, key=lambda cell: cell.table)


def _table_cells(name: str, result: Result, printed: dict[str, Any]) -> list[Cell]:
    """Table 1, one scene."""
    triangles = printed["scenes"][name]["sv_triangles_per_frame"]
    place = Place(ID, 1, name, "shadow_volume_triangles")
    cells = [make_cell(place, CALIBRATED, triangles, result.value("walkthrough.triangles"), "triangles")]
    for quantity, (statistic, scale, unit) in QUANTITIES.items():
        for column, number in printed["table1"][quantity][name].items():
            ours = result.value(f"{VARIANTS[column]}.{statistic}") / scale
            kind = _kind(name, column)
            if number < LEAST_DIGITS:
                kind = NOT_COMPARABLE
            cells.append(make_cell(Place(ID, 1, name, f"{statistic} {column}"), kind, number, ours, unit))
    for quantity, statistic in (("bandwidth_ratio", "total"), ("pixel_ratio", "processed")):
        for column, number in printed["table1"][quantity][name].items():
            ours = _ratio(result, statistic, "brute_force", VARIANTS[column])
            kind = _kind(name, column)
            cells.append(
                make_cell(Place(ID, 1, name, f"{quantity} BF:{column}"), kind, number, ours, "ratio")
            )
    return cells


def _kind(name: str, column: str) -> str:
    """Whether a row's column was aimed at."""
    return CALIBRATED if column == "BF" or (name, column) in CHOSEN else PREDICTED


def _claim_cells(name: str, result: Result, claims: dict[str, Any]) -> list[Cell]:
    """Table 2, one scene."""
    return [
        make_cell(
            Place(ID, 2, name, claim),
            PREDICTED,
            claims[claim],
            _ratio(result, statistic, variant, "hierarchical"),
            "ratio",
        )
        for claim, (statistic, variant) in CLAIMS.items()
    ]


def _ratio(result: Result, statistic: str, variant: str, other: str) -> float:
    """How many times more of something a variant needs than another."""
    return result.value(f"{variant}.{statistic}") / max(result.value(f"{other}.{statistic}"), 1)
