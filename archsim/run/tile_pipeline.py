"""Shadow maps drawn on a machine's tile pipeline, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from archsim.codec.codec import CodecSpec, tile_bits
from archsim.config import MachineConfig
from archsim.config.section import Section
from archsim.config.stages import StageConfig
from archsim.config.tiles import EvaluatorConfig, TileCacheConfig
from archsim.errors import fail
from archsim.lograster.depth_buffer import Drawn, draw
from archsim.lograster.evaluators import EvaluatorCost, evaluator_cost, evaluator_spec, with_rows
from archsim.lograster.grid import BITS, TILE, Grid, make_grid
from archsim.lograster.offset import OffsetSpec
from archsim.lograster.row_table import ENTRY_BYTES, LINE_BYTES, NO_TABLE, make_table
from archsim.lograster.work import UNITS, Target, map_bytes, tile_work
from archsim.lograster.z_cache import ZCacheSpec, ZState, cache_and_codec, plain_bytes
from archsim.machine.pipeline.build import PipelineMachine, pipeline_machine
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.pipeline.play import play
from archsim.run.listen import Listen, to_nothing
from archsim.run.progress import Progress, silent
from archsim.run.rendering import Piece, Play
from archsim.scene.mesh import Mesh
from archsim.shadowmap.fit import ShadowMap
from archsim.shadowmap.render import map_vertices
from archsim.trace.stream import PipelineWork


class Parts(NamedTuple):
    """What of a tile pipeline decides what is drawn and moved; the rest of it decides when."""

    design: int  # Design of the evaluator
    constant_bits: int  # of the evaluator, where rows follow from the first
    kept_lines: int  # of the evaluator's table; 0: it has none
    z_cache: ZCacheSpec
    codec: CodecSpec


class Hardware(NamedTuple):
    """A machine's tile pipeline."""

    machine: PipelineMachine
    evaluator: EvaluatorConfig
    parts: Parts


class DrawnMap(NamedTuple):
    """One map, drawn."""

    shadow_map: ShadowMap
    target: Target
    drawn: Drawn  # without the pipeline
    depth: np.ndarray  # int32 [rows, columns] that the pipeline left
    moved: np.ndarray  # int64 [2] blocks of depth read and written
    held: (
        np.ndarray
    )  # int64 [n] bytes that memory would hold for each block of the finished map that was touched

    @property
    def plain(self) -> np.ndarray:
        """Bytes of depth read and written if blocks were never compressed; the same blocks move then."""
        return self.moved * plain_bytes(self.target.codec)

    @property
    def plain_held(self) -> int:
        """Bytes of the touched blocks of the finished map if blocks were never compressed."""
        return len(self.held) * plain_bytes(self.target.codec)


class PlayedMap(NamedTuple):
    """One map on a machine."""

    map: DrawnMap
    counters: PipelineCounters

    def tasks(self, unit: str) -> int:
        """Tasks that a unit did."""
        return int(self.counters.unit_tasks[UNITS.index(unit)])

    @property
    def read(self) -> int:
        """Bytes of depth read."""
        return int(self.counters.unit_load_bytes[UNITS.index("decompress")])

    @property
    def written(self) -> int:
        """Bytes of depth written."""
        return int(self.counters.unit_store_bytes[UNITS.index("compress")])

    @property
    def table_read(self) -> int:
        """Bytes of the table of G(y') read."""
        return int(self.counters.unit_load_bytes[UNITS.index("fine")])


def hardware_of(config: MachineConfig) -> Hardware:
    """The tile pipeline that a machine is. ArchsimError if something is missing."""
    machine = pipeline_machine(config)
    for unit in UNITS:
        if config.find(unit, StageConfig) is None:
            what = f"machine '{config.name}' has no unit '{unit}', which shadow maps need"
            raise fail(what, key="machine.components")
    evaluator, tile_cache = _part(config, "fine", "evaluator"), _part(config, "depth_test", "tile_cache")
    assert isinstance(evaluator, EvaluatorConfig)
    assert isinstance(tile_cache, TileCacheConfig)
    fine = config.find("fine", StageConfig)
    if evaluator.has_table and (fine is None or fine.memory is None):
        what = f"machine '{config.name}': 'fine' has no memory to read the table of its evaluator from"
        raise fail(what, key="machine.components.fine")
    design = evaluator_spec(evaluator).design
    kept_lines = evaluator.kept_lines if evaluator.has_table else 0
    parts = Parts(design, evaluator.constant_bits, kept_lines, *cache_and_codec(tile_cache))
    return Hardware(machine, evaluator, parts)


def _part(config: MachineConfig, unit: str, kind: str) -> Section:
    """The one part of a kind that a unit is made with."""
    stage = config.find(unit, StageConfig)
    names = stage.parts if stage is not None else ()
    found = [config.components[name] for name in names if config.components[name].kind == kind]
    if len(found) != 1:
        what = (
            f"machine '{config.name}': unit '{unit}' must have one {kind} among its parts, not {len(found)}"
        )
        raise fail(what, key=f"machine.components.{unit}")
    return found[0]


def cost_of(hardware: Hardware, rows: int) -> EvaluatorCost:
    """What the hardware's evaluator takes for maps of up to so many rows."""
    return evaluator_cost(evaluator_spec(hardware.evaluator), rows, BITS)


def rows_of(parts: Parts, columns: int, rows: int, ratio: float) -> Grid:
    """The samples of a map where the evaluator puts them."""
    return with_rows(make_grid(columns, rows, ratio), parts.design, parts.constant_bits)


def targets_of(
    parts: Parts, maps: Sequence[ShadowMap], sizes: Sequence[tuple[int, int]], offset: OffsetSpec
) -> list[Target]:
    """The maps side by side in memory, the table of each behind it."""
    targets, base = [], 0
    for shadow_map, (columns, rows) in zip(maps, sizes, strict=True):
        grid = rows_of(parts, columns, rows, shadow_map.ratio)
        target = Target(grid, parts.codec, parts.z_cache, base, offset)
        if shadow_map.ratio > 1 and parts.kept_lines:
            table = make_table(parts.design, parts.kept_lines, base + map_bytes(target))
            target = target._replace(table=table)
        targets.append(target)
        base = _end(target)
    return targets


def _end(target: Target) -> int:
    """The address behind a map and its table."""
    end = target.base + map_bytes(target)
    if target.table == NO_TABLE:
        return end
    return end + -(-len(target.grid.y) * ENTRY_BYTES // LINE_BYTES) * LINE_BYTES


def phase_of(shadow_map: ShadowMap) -> str:
    """The name of a map's phase."""
    return f"map_{shadow_map.name.replace(' ', '_')}"


def draw_maps(mesh: Mesh, maps: Sequence[ShadowMap], targets: Sequence[Target], play: Play) -> list[DrawnMap]:
    """Draw a mesh into each map, one piece of work each, and once more without the pipeline."""
    drawn_maps, needed = [], max((_end(target) for target in targets), default=0)
    for number, (shadow_map, target) in enumerate(zip(maps, targets, strict=True)):
        vertices = map_vertices(mesh, shadow_map)
        work, state = tile_work(vertices, mesh.triangles, target)
        play(Piece(phase_of(shadow_map), work, needed, (number, len(maps))))
        drawn = draw(vertices, mesh.triangles, target.grid, target.offset)
        rows, columns = drawn.depth.shape
        depth = state.depth[:rows, :columns]
        held = _held_bytes(target.codec, state, drawn.touched)
        drawn_maps.append(DrawnMap(shadow_map, target, drawn, depth, state.moved, held))
    return drawn_maps


class TilePlayer:
    """Maps on a tile pipeline, one after the other; who listens hears of each as a phase."""

    def __init__(self, model: str, machine: PipelineMachine, progress: Progress, listen: Listen):
        self.model, self.machine, self.progress, self.listen = model, machine, progress, listen
        self.counters: list[PipelineCounters] = []

    def play(self, piece: Piece) -> None:
        """Play the work of a map. ArchsimError if the maps do not fit into the memory."""
        assert isinstance(piece.work, PipelineWork)
        if piece.needed_bytes > self.machine.dram_bytes:
            what = f"the maps take {piece.needed_bytes} bytes; the memory has {self.machine.dram_bytes}"
            raise fail(what, key="machine.components")
        number, maps = piece.part
        self.progress("shadow maps", number, maps)
        heard = self.listen(piece.phase, self.machine)
        self.counters.append(play(self.model, self.machine, piece.work, None, heard))
        self.progress("shadow maps", number + 1, maps)

    def played(self, maps: Sequence[DrawnMap]) -> list[PlayedMap]:
        """The maps with what playing them took."""
        return [PlayedMap(*each) for each in zip(maps, self.counters, strict=True)]


def play_maps(
    model: str, hardware: Hardware, mesh: Mesh, maps: Sequence[ShadowMap], targets: Sequence[Target]
) -> list[PlayedMap]:
    """Draw a mesh into each map on the hardware."""
    player = TilePlayer(model, hardware.machine, silent, to_nothing)
    return player.played(draw_maps(mesh, maps, targets, player.play))


def _held_bytes(codec: CodecSpec, state: ZState, touched: np.ndarray) -> np.ndarray:
    """Bytes that memory would hold for each of the touched blocks of a finished map."""
    blocks = touched_blocks(touched, codec.side)
    return np.asarray(tile_bits(codec, state.depth, blocks)[blocks] // 8)


def touched_blocks(touched: np.ndarray, side: int) -> np.ndarray:
    """Bool [block rows, block columns]: blocks of `side` samples with a tile that is `touched`."""
    each = side // TILE
    rows, columns = (-(-length // each) * each for length in touched.shape)
    whole = np.zeros((rows, columns), np.bool_)
    whole[: touched.shape[0], : touched.shape[1]] = touched
    return np.asarray(whole.reshape(rows // each, each, columns // each, each).any(axis=(1, 3)))
