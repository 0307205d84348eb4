"""Figure 6: compression of finished depth buffers, and what polygon offset meets on the way. [Lloyd07] sec.
5.1, 4.2.5
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.codec.codec import DEPTH_BITS, Codec, CodecSpec, make_codec, tile_bits
from archsim.codec.lloyd import FirstRow, LastDelta
from archsim.lograster.depth_buffer import DrawCounts
from archsim.lograster.offset import OffsetSpec, Switch
from archsim.reproduce.lloyd2007.views import load_walk
from archsim.run.progress import Progress
from archsim.run.tile_pipeline import touched_blocks
from archsim.shadowmap.families import make_maps
from archsim.shadowmap.render import render

RESOLUTIONS = (256, 512, 1024, 2048)
MAPS = {
    "linear": "fp_lispsm",
    "logarithmic": "logpsm",
}  # rasterization -> family; of each its warped maps, square
OFFSET = OffsetSpec(1.0, 0.0, int(Switch.INTERPOLATED))

READINGS = {  # of the paper's figure 5
    "as in table 5": make_codec(Codec.LLOYD),
    "z0 at the far end": make_codec(Codec.LLOYD, first_row=FirstRow.FAR),
    "row 3 from row 2": make_codec(Codec.LLOYD, last_delta=LastDelta.ROW_2),
    "both": make_codec(Codec.LLOYD, first_row=FirstRow.FAR, last_delta=LastDelta.ROW_2),
}
CODECS: dict[str, CodecSpec] = {
    "lloyd": make_codec(Codec.LLOYD),
    "anchor": make_codec(Codec.ANCHOR),
    "ddpcm": make_codec(Codec.DDPCM),
    "ddpcm 2": make_codec(Codec.DDPCM_TWO_PLANES),
    "plane": make_codec(Codec.PLANE),
    "hasselgren": make_codec(Codec.HASSELGREN),
    "hasselgren 2": make_codec(Codec.HASSELGREN_TWO_PLANES),
    "depth offset": make_codec(Codec.DEPTH_OFFSET),
    **READINGS,
}


LARGE = 8  # samples along a side of the other tiles that are measured
LARGE_CODECS: dict[str, CodecSpec] = {
    f"{name} {LARGE}x{LARGE}": make_codec(codec, LARGE)
    for name, codec in (
        ("ddpcm", Codec.DDPCM),
        ("ddpcm 2", Codec.DDPCM_TWO_PLANES),
        ("plane", Codec.PLANE),
        ("hasselgren", Codec.HASSELGREN),
        ("hasselgren 2", Codec.HASSELGREN_TWO_PLANES),
        ("depth offset", Codec.DEPTH_OFFSET),
    )
}
ALL_CODECS = {**CODECS, **LARGE_CODECS}


class Buffers(NamedTuple):
    """All maps of a walk at one resolution and rasterization."""

    plain: dict[str, int]  # codec -> bits of the touched tiles as they are
    bits: dict[str, int]  # codec -> bits that memory holds
    counts: DrawCounts

    def ratio(self, codec: str) -> float:
        """Plain bits over those held."""
        return self.plain[codec] / max(self.bits[codec], 1)


def measure(scene: str, progress: Progress) -> dict[tuple[str, int], Buffers]:
    """(rasterization, resolution) -> Buffers of one scene's walk."""
    walk = load_walk(scene)
    jobs = [(name, size) for name in MAPS for size in RESOLUTIONS]
    measured = {}
    for done, (rasterization, size) in enumerate(jobs):
        progress(f"{scene}: depth buffers", done, len(jobs))
        plain, bits = dict.fromkeys(ALL_CODECS, 0), dict.fromkeys(ALL_CODECS, 0)
        counts, most = np.zeros(len(DrawCounts._fields)), 0.0
        for frame in walk.frames:
            for shadow_map in make_maps(MAPS[rasterization], frame.view, frame.light):
                if shadow_map.name.split()[0] in ("near", "far"):
                    continue
                drawn = render(walk.mesh, shadow_map, (size, size), OFFSET)
                counts += drawn.counts
                most = max(most, drawn.counts.excess_most)
                for name, codec in ALL_CODECS.items():
                    touched = touched_blocks(drawn.touched, codec.side)
                    plain[name] += int(touched.sum()) * DEPTH_BITS * codec.side**2
                    bits[name] += int(tile_bits(codec, drawn.depth, touched).sum())
        totals = DrawCounts._make([*(int(value) for value in counts[:-2]), float(counts[-2]), most])
        measured[rasterization, size] = Buffers(plain, bits, totals)
    progress(f"{scene}: depth buffers", len(jobs), len(jobs))
    return measured
