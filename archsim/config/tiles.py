"""Parts of a tile pipeline that belong to a unit: what gives it the rows of a map, and where it keeps tiles."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from archsim.config.section import Count, Finding, Section, Small, report
from archsim.units import Bytes, Cycles, format_bytes

DEPTH_BYTES = 3  # of a sample
ONLY_4X4 = ("lloyd", "anchor")  # codecs that are defined for no other tile

PartCycles = Annotated[Cycles, Field(ge=1, le=1000)]


class EvaluatorConfig(Section):
    """What evaluates G(y') for the rows of a 4 x 4 tile ([Lloyd07] sec. 4.2.2); its units are no faster than it."""

    kind: Literal["evaluator"]
    # full: an exponential for each row; incremental: one, the other rows follow from it (eq. 7, 8); table: all rows
    # precomputed; table_first_row: the first row of each tile, the others follow from it
    design: Literal["full", "incremental", "table", "table_first_row"]
    exponentials: Small = 1  # units that evaluate one exponential a cycle each; the tables use none
    exponential_cycles: PartCycles  # latency of an exponential
    multiply_cycles: PartCycles  # latency of a multiply-add
    constant_bits: Annotated[int, Field(ge=1, le=36)] = (
        28  # fraction bits of P and Q (eq. 8) where rows follow
    )
    table_ports: Small = 1  # rows that one access to the table's lines delivers
    table_cycles: PartCycles  # latency of such an access
    kept_lines: Small = 16  # lines of 64 bytes of the table, which lies in memory, that are kept on chip

    @property
    def has_table(self) -> bool:
        return self.design in ("table", "table_first_row")


class TileCacheConfig(Section):
    """A cache of whole depth tiles; memory holds them as the codec compressed them ([Lloyd07] sec. 4.3)."""

    kind: Literal["tile_cache"]
    size: Annotated[Bytes, Field(ge=1, le=2**26)]  # of all tiles together, 3 bytes a sample
    ways: Count  # tiles of a set
    tile: Literal[4, 8] = 4  # samples along a side of what is cached, compressed and moved as one
    # how memory holds a tile; `none`: as it is; `_2`: with two planes where one does not do
    codec: Literal[
        "none",
        "lloyd",
        "anchor",
        "ddpcm",
        "ddpcm_2",
        "plane",
        "hasselgren",
        "hasselgren_2",
        "depth_offset",
    ] = "lloyd"
    granularity: Annotated[Bytes, Field(ge=1, le=192)] = 16  # memory moves a tile in multiples of this
    first_row: Literal["near", "far"] = "near"  # for lloyd: the end of y' at which z0 is
    last_delta: Literal["anchor", "row_2"] = "anchor"  # for lloyd: what row 3's difference is relative to

    @property
    def tile_bytes(self) -> int:
        return DEPTH_BYTES * self.tile * self.tile

    @model_validator(mode="after")
    def _check(self) -> TileCacheConfig:
        report(_check_tile_cache(self))
        return self


def _check_tile_cache(cache: TileCacheConfig) -> list[Finding]:
    found = []
    set_bytes = cache.ways * cache.tile_bytes
    if cache.size % set_bytes:
        tiles = f"{cache.ways} ways of {format_bytes(cache.tile_bytes)}"
        found.append(Finding(("size",), f"must be a multiple of {tiles}, not {cache.size} B"))
    if cache.codec in ONLY_4X4 and cache.tile != 4:
        what = f"'{cache.codec}' is not defined for tiles of {cache.tile} x {cache.tile}"
        found.append(Finding(("codec",), what))
    if cache.granularity > cache.tile_bytes:
        what = (
            f"must be at most a tile, {format_bytes(cache.tile_bytes)}, not {format_bytes(cache.granularity)}"
        )
        found.append(Finding(("granularity",), what))
    return found
