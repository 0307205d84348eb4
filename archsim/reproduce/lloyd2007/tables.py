"""The tables and pictures of the reproduction. What the paper prints is in
`experiments/lloyd2007/printed.yaml`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import yaml

from archsim import resources
from archsim.codec import lloyd
from archsim.codec.codec import DEPTH_BITS, Codec, make_codec, stored_bits
from archsim.lograster.grid import BITS, TILE
from archsim.lograster.offset import Slopes, excess
from archsim.lograster.parameterization import bits_bound, bits_needed, largest_ratio
from archsim.reproduce.cells import EXACT, PREDICTED, Cell, Paper, Place, make_cell, new_cell
from archsim.reproduce.lloyd2007 import aliasing, pictures
from archsim.reproduce.lloyd2007.compression import (
    ALL_CODECS,
    LARGE_CODECS,
    MAPS,
    READINGS,
    RESOLUTIONS,
    Buffers,
    measure,
)
from archsim.reproduce.lloyd2007.configuration import configuration
from archsim.reproduce.lloyd2007.designs import DESIGNS, MAP_ROWS, hardware_with, play_designs
from archsim.reproduce.lloyd2007.pipeline import Played, moved_bytes, play_families, storage_bytes
from archsim.reproduce.lloyd2007.views import ID, SCENES
from archsim.reproduce.processes import in_processes
from archsim.reproduce.reproduction import Reproduction
from archsim.run.progress import Progress, silent
from archsim.run.tile_pipeline import cost_of

EQUAL_TABLES = {"m": 9, "wrong pixels": 13}  # what is equal -> table
ONE_PLANE = ("anchor", "ddpcm", "plane", "hasselgren")  # the schemes that the paper compares
Measured = Mapping[str, Mapping[tuple[str, int], Buffers]]  # scene -> (rasterization, resolution) -> Buffers

PAPER = Paper(
    id=ID,
    title="Lloyd, Govindaraju, Molnar, Manocha 2007: Practical logarithmic rasterization for low-error shadow maps",
    tables={
        1: "Precision and formats (equations 9 to 11, figure 5)",
        2: "Bits that 4096 rows need, by f/n (equations 9 and 10)",
        3: "Evaluators of G(y') for 4096 rows (section 4.2.2)",
        4: "Generalized polygon offset (section 4.2.5)",
        5: "Depth compression by scene, resolution and rasterization (figure 6)",
        6: "The readings of figure 5, compared (section 4.3)",
        7: "Size of texels in a 512 x 512 image, with 512 x 512 texels in all maps (figure 7)",
        8: "Texels needed for errors up to one pixel, and how they grow with f/n (section 3.2)",
        9: "The tile pipeline at equal error in the image: m",
        10: "A square over all of a 1024 x 1024 map, by evaluator",
        11: "Depth compression in tiles of 8 x 8 samples, with the codecs that are defined for them",
        12: "The statements of section 5.1 on figure 6, as numbers",
        13: "The tile pipeline at equal error in the image: pixels whose shadow is wrong",
    },
    notes={
        1: ["(f/n)max is compared with the two digits that the paper prints."],
        3: ["Latencies are ours: exponentials 11 clocks, multiply-adds 3, table accesses 2."],
        4: [
            "Over the warped maps of all scenes, frames and resolutions of table 5, logarithmic rasterization.",
            "Differences are relative to the true m_z. A triangle's is at most part (1 - part) of the change of its "
            "slope over its own extent, so that the mean grows in proportion to the triangles: 0.001 takes triangles "
            "that reach over less than a hundredth of their distance, and our grounds are large. With those "
            "triangles counted, too, in which nothing switches, the mean is that of the last column.",
            "The greatest difference is that of one triangle over the whole map, with f/n = 10,000 and its switch "
            "where the difference is greatest.",
        ],
        5: [
            "Plain bits over bits held in memory, in units of 64; tiles of 4 x 4 samples that nothing touched are left "
            "out, tiles clamped to depth 0 are not. ddpcm 2 and hasselgren 2 may use two planes.",
            "Scenes, camera paths and the linear maps (face-partitioned with the light-space perspective warp) are "
            "ours: the paper's curves cannot be compared, its three statements can.",
        ],
        7: ["m is the longer side of a texel in the image in pixels. The paper shows colours, not numbers."],
        8: [
            "In images of 512 x 512, for a nearly overhead directional light. A logarithm grows by equal steps for "
            "equal factors of f/n."
        ],
        9: [
            "Means over the frames of the way through the town on configs/machines/lloyd2007.yaml, all maps of a "
            "family one after the other. logpsm has 512 x 512 texels; the others have as many as it takes for an equal "
            "error: the same m below which 95 % of all pixels stay.",
            "Read and written are depths between z cache and memory; partly drawn tiles count each time they leave. "
            "Compression is what plain tiles would move over what is moved; plain is the same for all codecs.",
        ],
        10: [
            "The same machine with the latency and interval of each evaluator of table 3; those with a table read it "
            "from memory ahead of the tiles, and keep 16 lines of 64 bytes.",
        ],
        11: ["As table 5; a tile counts if anything touched it."],
        12: [
            "Ratios of table 5, averaged over the scenes. The others are those with one plane: anchor, ddpcm, plane "
            "and hasselgren. Depth offset is left out, as in the paper.",
        ],
        13: ["As table 9; as many pixels as with logpsm have a shadow that differs from the traced one."],
    },
)


def reproduce(progress: Progress = silent) -> Reproduction:
    """Measure everything, two scenes at a time."""
    printed = yaml.safe_load((resources.experiment(ID) / "printed.yaml").read_text(encoding="utf-8"))
    jobs = [(scene,) for scene in SCENES]
    measured = dict(
        zip(SCENES, in_processes(measure, jobs, min(2, os.cpu_count() or 1), progress), strict=True)
    )
    picture, families = aliasing.figure7()
    played = play_families(progress)
    cells = [
        *precision_cells(printed),
        *bits_cells(),
        *evaluator_cells(),
        *offset_cells(printed["polygon_offset"], measured),
        *compression_cells(measured),
        *statement_cells(measured),
        *aliasing_cells(printed["figure7"]["maps"], families),
        *storage_cells(printed),
        *pipeline_cells(played),
        *design_cells(),
    ]
    checks = tuple(check for each in played.values() for check in each.checks)
    shown = pictures.all_pictures(measured, picture, families)
    return Reproduction({}, cells, shown, checks, configuration())


def precision_cells(printed: Mapping[str, Any]) -> list[Cell]:
    """Table 1."""
    precision, compression = printed["precision"], printed["depth_compression"]
    fields = sum(sum(row) for row in compression["fig5c_bits"])
    codec = make_codec(Codec.LLOYD)
    held = stored_bits(codec, lloyd.USED_BITS)
    rows = [
        ("bits of G", precision["g_bits"], BITS, "bits"),
        ("largest f/n of 4096 rows", precision["fn_max"], _digits(largest_ratio(MAP_ROWS), 2), ""),
        ("bits of figure 5c", fields, lloyd.USED_BITS, "bits"),
        ("bits of a compressed tile", compression["budget_bits"], held, "bits"),
        ("compression of a tile", compression["ratio"], DEPTH_BITS * TILE * TILE / held, ""),
    ]
    return [
        make_cell(Place(ID, 1, "paper", column), EXACT, theirs, ours, unit)
        for column, theirs, ours, unit in rows
    ]


def _digits(value: float, digits: int) -> float:
    return float(f"{value:.{digits - 1}e}")


def bits_cells() -> list[Cell]:
    """Table 2."""
    cells = []
    for ratio in (10, 100, 1000, 10_000, 32_768, 100_000):
        row = f"f/n = {ratio:,}"
        cells.append(new_cell(Place(ID, 2, row, "b_min"), bits_needed(MAP_ROWS, ratio), "bits"))
        cells.append(new_cell(Place(ID, 2, row, "bound"), round(bits_bound(MAP_ROWS, ratio), 3), "bits"))
    return cells


def evaluator_cells() -> list[Cell]:
    """Table 3."""
    units = {"table_bytes": "bytes", "latency_cycles": "clocks", "interval_cycles": "clocks a tile"}
    return [
        new_cell(Place(ID, 3, name, column), value, units.get(column, "units"))
        for name in DESIGNS
        for column, value in cost_of(hardware_with(name), MAP_ROWS)._asdict().items()
    ]


def offset_cells(printed: Mapping[str, Any], measured: Measured) -> list[Cell]:
    """Table 4."""
    cells = []
    most = printed["triangles_with_switch_below_percent"], printed["mean_max_relative_difference_below"]
    for scene, buffers in measured.items():
        counts = [
            each.counts for (rasterization, _), each in buffers.items() if rasterization == "logarithmic"
        ]
        switches, triangles = sum(c.switches for c in counts), sum(c.triangles for c in counts)
        share = 100.0 * switches / max(triangles, 1)
        excesses = sum(c.excess_sum for c in counts)
        mean = excesses / max(switches, 1)
        for column, limit, ours, unit in (
            ("triangles_with_switch", most[0], share, "%"),
            ("mean_of_greatest_difference", most[1], mean, "of the offset"),
        ):
            cells.append(make_cell(Place(ID, 4, scene, column), PREDICTED, [0, limit], ours, unit))
        place = Place(ID, 4, scene, "mean_over_all_triangles")
        cells.append(new_cell(place, excesses / max(triangles, 1), "of the offset"))
    about = printed["max_relative_difference_about"]
    place = Place(ID, 4, "town", "greatest_difference_possible")
    return [*cells, make_cell(place, PREDICTED, about, greatest_excess(10_000.0), "of the offset")]


def greatest_excess(ratio: float) -> float:
    """The most that interpolation exceeds the true slope, over triangles that span the map."""
    change = -(1 - 1 / ratio)
    return max(
        float(excess(Slopes(1 + change * y, 1.0, change), 0.0, 1.0)) for y in np.linspace(0.01, 0.999, 500)
    )


def compression_cells(measured: Measured) -> list[Cell]:
    """Tables 5, 6 and 11."""
    cells = []
    for rasterization in MAPS:
        for scene, buffers in measured.items():
            for size in RESOLUTIONS:
                for codec in ALL_CODECS:
                    table = 6 if codec in READINGS else 11 if codec in LARGE_CODECS else 5
                    place = Place(ID, table, f"{scene} {rasterization} {size}", codec)
                    cells.append(new_cell(place, round(buffers[rasterization, size].ratio(codec), 3), ""))
    return sorted(cells, key=lambda cell: cell.table)


def statement_cells(measured: Measured) -> list[Cell]:
    """Table 12."""

    def mean(rasterization: str, size: int, codec: str) -> float:
        return float(np.mean([buffers[rasterization, size].ratio(codec) for buffers in measured.values()]))

    cells = []
    for size in RESOLUTIONS:
        row = str(size)
        linear = [mean("linear", size, codec) for codec in ONE_PLANE]
        own = {rasterization: mean(rasterization, size, "lloyd") for rasterization in MAPS}
        columns = [
            ("linear: over the best other", own["linear"] / max(linear)),
            ("linear: over the mean other", own["linear"] / float(np.mean(linear))),
            ("logarithmic: best other", max(mean("logarithmic", size, codec) for codec in ONE_PLANE)),
            ("logarithmic: own", own["logarithmic"]),
            ("logarithmic over linear: own", own["logarithmic"] / own["linear"]),
        ]
        cells += [new_cell(Place(ID, 12, row, column), round(ours, 3), "") for column, ours in columns]
    return cells


def aliasing_cells(printed: Mapping[str, int], families: Mapping[str, aliasing.Fitted]) -> list[Cell]:
    """Table 7."""
    cells = []
    for family, fitted in families.items():
        m = fitted.errors.error
        cells.append(
            make_cell(Place(ID, 7, family, "maps"), EXACT, printed[family], len(fitted.maps), "maps")
        )
        for column, ours in (("mean", m.mean()), ("95 % below", np.percentile(m, 95)), ("largest", m.max())):
            cells.append(new_cell(Place(ID, 7, family, f"m: {column}"), float(ours), "pixels"))
    return cells


def storage_cells(printed: Mapping[str, Any]) -> list[Cell]:
    """Table 8."""
    cells = []
    needed = aliasing.storage()
    for family, images in needed.items():
        for ratio, texels in zip(aliasing.RATIOS, images, strict=True):
            cells.append(new_cell(Place(ID, 8, family, f"f/n = {ratio:,}"), texels, "images"))
    for family, power in printed["error_order"].items():
        span = math.log(aliasing.RATIOS[-1] / aliasing.RATIOS[1])
        ours = math.log(needed[family][-1] / needed[family][1]) / span
        cells.append(make_cell(Place(ID, 8, family, "power of f/n"), PREDICTED, power, ours, ""))
    steps = np.diff(needed["logpsm"])
    place = Place(ID, 8, "logpsm", "last step over first")
    cells.append(make_cell(place, PREDICTED, 1, float(steps[-1] / steps[0]), ""))
    directional, point = aliasing.mean_partitions()
    for column, ours in (("directional", directional), ("point", point)):
        place = Place(ID, 8, "logpsm", f"maps for a {column} light")
        cells.append(make_cell(place, PREDICTED, printed["partitions"][column], ours, "maps"))
    return cells


def pipeline_cells(played: Mapping[tuple[str, str], Played]) -> list[Cell]:
    """Tables 9 and 13."""
    cells = []
    for (equal, row), each in played.items():
        columns = [
            ("m", each.errors.m, "pixels"),
            ("wrong", 100 * each.errors.wrong, "%"),
            ("maps", each.maps, ""),
            ("storage", storage_bytes(each) / 1024, "KiB"),
            ("cycles", each.cycles, ""),
            ("tiles a cycle", each.tiles / max(each.cycles, 1), ""),
            ("read", each.read / 1024, "KiB"),
            ("written", each.written / 1024, "KiB"),
            ("plain", each.plain / 1024, "KiB"),
            ("compression", each.plain / max(moved_bytes(each), 1), ""),
        ]
        table = EQUAL_TABLES[equal]
        cells += [new_cell(Place(ID, table, row, column), ours, unit) for column, ours, unit in columns]
    return cells


def design_cells() -> list[Cell]:
    """Table 10."""
    cells = []
    for row, each in play_designs().items():
        columns = [
            ("cycles", each.cycles, ""),
            ("tiles a cycle", each.tiles / each.cycles, ""),
            ("table read", each.table_bytes / 1024, "KiB"),
        ]
        cells += [new_cell(Place(ID, 10, row, column), ours, unit) for column, ours, unit in columns]
    return cells
