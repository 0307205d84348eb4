"""What the paper claims and never tabulates: at equal error in the image, the bandwidth and time of the tile
pipeline.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim import resources
from archsim.config import load_machine
from archsim.reproduce.lloyd2007.equal_error import MEASURES, OFFSET, Equal, Errors, equal_errors, load_shots
from archsim.run.pipeline_metrics import pipeline_checks
from archsim.run.progress import Progress
from archsim.run.result import Check
from archsim.run.tile_pipeline import Hardware, PlayedMap, hardware_of, play_maps, targets_of
from archsim.scene.mesh import Mesh

CODECS = ("lloyd", "hasselgren_2")  # besides no codec, whose bytes follow from either
DEPTH_BYTES = 3


class Played(NamedTuple):
    """The maps of a family, drawn one after the other; means over the frames, but for the errors."""

    errors: Errors
    maps: float
    texels: float
    cycles: float
    tiles: float  # that the fine rasterizer took
    read: float  # bytes of depth
    written: float
    plain: float  # bytes of depth read and written without compression
    checks: list[Check]


def play_families(progress: Progress) -> dict[tuple[str, str], Played]:
    """(what is equal, 'family, codec') -> Played."""
    mesh, shots = load_shots()
    machine = resources.config("machines", "lloyd2007")
    hardware = {
        codec: hardware_of(load_machine(machine, [f"components.z_cache.codec={codec}"])) for codec in CODECS
    }
    found: dict[tuple[str, str], Played] = {}
    known: dict[tuple[str, int], dict[str, Played]] = {}
    total = sum(len(families) + 1 for _, families in MEASURES.values())
    for done, (measure, family, equal) in enumerate(equal_errors(mesh, shots)):
        progress("tile pipeline at equal error", done, total)
        key = family, equal.texels
        if key not in known:
            known[key] = {codec: _play(mesh, equal, hardware[codec], family) for codec in CODECS}
        found |= {(measure, f"{family}, {codec}"): played for codec, played in known[key].items()}
    progress("tile pipeline at equal error", total, total)
    return found


def _play(mesh: Mesh, equal: Equal, hardware: Hardware, name: str) -> Played:
    """Every frame's maps on the pipeline."""
    maps: list[PlayedMap] = []
    checks: list[Check] = []
    for number, fitted in enumerate(equal.fitted):
        targets = targets_of(hardware.parts, fitted.maps, fitted.sizes, OFFSET)
        for each in play_maps("compiled", hardware, mesh, fitted.maps, targets):
            where = f"{name}, frame {number}: {each.map.shadow_map.name}"
            same = bool(np.array_equal(each.map.depth, each.map.drawn.depth))
            checks.append(Check(f"{where}: depths of drawing", same, ""))
            checks += pipeline_checks(where, hardware.machine, each.counters)
            maps.append(each)
    frames = len(equal.fitted)
    return Played(
        errors=equal.errors,
        maps=len(maps) / frames,
        texels=sum(each.map.depth.size for each in maps) / frames,
        cycles=sum(each.counters.cycles for each in maps) / frames,
        tiles=sum(each.tasks("fine") for each in maps) / frames,
        read=sum(each.read for each in maps) / frames,
        written=sum(each.written for each in maps) / frames,
        plain=float(sum(each.map.plain.sum() for each in maps)) / frames,
        checks=checks,
    )


def moved_bytes(played: Played) -> float:
    """Depths between z cache and memory, both ways."""
    return played.read + played.written


def storage_bytes(played: Played) -> float:
    """Memory of the maps; a compressed tile keeps its place, so that compression saves bandwidth only."""
    return played.texels * DEPTH_BYTES
