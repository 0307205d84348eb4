"""What the paper claims and never tabulates: at equal error in the image, the bandwidth and time of the tile
pipeline.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim import resources
from archsim.codec.codec import Codec, CodecSpec, make_codec
from archsim.config import load_machine
from archsim.lograster.grid import TILE, make_grid
from archsim.lograster.work import COMPRESS, DECOMPRESS, UNITS, Target, tile_work
from archsim.lograster.z_cache import make_z_cache
from archsim.machine.pipeline.build import pipeline_machine
from archsim.machine.pipeline.play import play
from archsim.reproduce.lloyd2007.aliasing import Fitted, fit_family
from archsim.reproduce.lloyd2007.views import load_walk
from archsim.run.pipeline_metrics import pipeline_checks
from archsim.run.progress import Progress
from archsim.run.result import Check
from archsim.shadowmap.picture import take_picture
from archsim.shadowmap.render import map_vertices

FAMILIES = ("fp_lispsm", "csm_lispsm", "logpsm")
TEXELS = 512 * 512  # of logpsm; the others get what the same error takes
IMAGE = 512
PERCENT = 95  # of pixels whose m is compared
Z_CACHE = make_z_cache(48 * 512, 4)  # 24 KiB of plain tiles
BURST_BITS = 128
CODECS: dict[str, CodecSpec] = {
    "plain": make_codec(Codec.NONE, granularity_bits=BURST_BITS),
    "lloyd": make_codec(Codec.LLOYD, granularity_bits=BURST_BITS),
    "hasselgren 2": make_codec(Codec.HASSELGREN_TWO_PLANES, granularity_bits=BURST_BITS),
}
DEPTH_BYTES = 3


class Played(NamedTuple):
    """The maps of a family, drawn one after the other."""

    maps: int
    texels: int
    error: float  # m that PERCENT of the pixels stay below
    cycles: int
    tiles: int  # that the fine rasterizer took
    read: int  # bytes of depth
    written: int
    checks: list[Check]


def equal_errors() -> dict[str, Fitted]:
    """Families with as many texels as logpsm's error takes, for the first frame of the town."""
    walk = load_walk("town")
    frame = walk.frames[0]
    picture = take_picture(walk.mesh, frame.camera, frame.view, IMAGE, IMAGE)

    def fitted(family: str, texels: int) -> Fitted:
        return fit_family(family, frame.view, frame.light, picture, texels)

    goal = error_of(fitted("logpsm", TEXELS))
    return {
        family: fitted(family, round(TEXELS * (error_of(fitted(family, TEXELS)) / goal) ** 2))
        for family in FAMILIES
    }


def error_of(fitted: Fitted) -> float:
    """m that PERCENT of the pixels stay below."""
    return float(np.percentile(fitted.errors.error, PERCENT))


def play_families(progress: Progress) -> dict[str, Played]:
    """'family, codec' -> Played."""
    mesh = load_walk("town").mesh
    machine = pipeline_machine(load_machine(resources.config("machines", "lloyd2007")))
    families = equal_errors()
    jobs = [(family, codec) for family in FAMILIES for codec in CODECS]
    found = {}
    for done, (family, codec) in enumerate(jobs):
        progress("tile pipeline", done, len(jobs))
        fitted = families[family]
        totals = np.zeros(4, dtype=np.int64)
        checks: list[Check] = []
        for shadow_map, size in zip(fitted.maps, fitted.sizes, strict=True):
            target = Target(make_grid(*size, shadow_map.ratio), CODECS[codec], Z_CACHE)
            work, _ = tile_work(map_vertices(mesh, shadow_map), mesh.triangles, target)
            counters = play("compiled", machine, work)
            checks += pipeline_checks(f"{family}, {codec}: {shadow_map.name}", machine, counters)
            totals += (
                counters.cycles,
                counters.unit_tasks[UNITS.index("fine")],
                counters.unit_load_bytes[DECOMPRESS],
                counters.unit_store_bytes[COMPRESS],
            )
        texels = sum(columns * rows for columns, rows in fitted.sizes)
        cycles, tiles, read, written = (int(total) for total in totals)
        found[f"{family}, {codec}"] = Played(
            len(fitted.maps), texels, error_of(fitted), cycles, tiles, read, written, checks
        )
    progress("tile pipeline", len(jobs), len(jobs))
    return found


def storage_bytes(played: Played) -> int:
    """Memory of the maps; a compressed tile keeps its place, so that compression saves bandwidth only."""
    return played.texels * DEPTH_BYTES


def samples_a_cycle(played: Played) -> float:
    """Samples that the fine rasterizer went through."""
    return TILE * TILE * played.tiles / max(played.cycles, 1)
