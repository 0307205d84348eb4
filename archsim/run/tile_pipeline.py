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
from archsim.lograster.row_table import ENTRY_BYTES, LINE_BYTES, make_table
from archsim.lograster.work import UNITS, Target, map_bytes, tile_work
from archsim.lograster.z_cache import ZCacheSpec, ZState, cache_and_codec, plain_bytes
from archsim.machine.pipeline.build import PipelineMachine, pipeline_machine
from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.pipeline.play import play
from archsim.run.listen import Listen, to_nothing
from archsim.run.progress import Progress, silent
from archsim.scene.mesh import Mesh
from archsim.shadowmap.fit import ShadowMap
from archsim.shadowmap.render import map_vertices


class Hardware(NamedTuple):
    """A machine's tile pipeline and the parts of it that decide what is drawn and moved."""

    machine: PipelineMachine
    evaluator: EvaluatorConfig
    z_cache: ZCacheSpec
    codec: CodecSpec


class PlayedMap(NamedTuple):
    """One map, drawn."""

    shadow_map: ShadowMap
    target: Target
    drawn: Drawn  # without the pipeline
    depth: np.ndarray  # int32 [rows, columns] that the pipeline left
    counters: PipelineCounters
    moved: np.ndarray  # int64 [2] blocks of depth read and written
    finished: tuple[int, int]  # bytes of the blocks of the finished map that something touched: plain, held

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

    @property
    def plain(self) -> np.ndarray:
        """Bytes of depth read and written if blocks were never compressed; the same blocks move then."""
        return self.moved * plain_bytes(self.target.codec)


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
    return Hardware(machine, evaluator, *cache_and_codec(tile_cache))


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


def rows_of(hardware: Hardware, columns: int, rows: int, ratio: float) -> Grid:
    """The samples of a map where the hardware's evaluator puts them."""
    evaluator = evaluator_spec(hardware.evaluator)
    return with_rows(make_grid(columns, rows, ratio), evaluator.design, hardware.evaluator.constant_bits)


def targets_of(
    hardware: Hardware, maps: Sequence[ShadowMap], sizes: Sequence[tuple[int, int]], offset: OffsetSpec
) -> list[Target]:
    """The maps side by side in memory, the table of each behind it. ArchsimError if they do not fit."""
    targets, base = [], 0
    for shadow_map, (columns, rows) in zip(maps, sizes, strict=True):
        grid = rows_of(hardware, columns, rows, shadow_map.ratio)
        target = Target(grid, hardware.codec, hardware.z_cache, base, offset)
        base += map_bytes(target)
        if shadow_map.ratio > 1 and hardware.evaluator.has_table:
            design = evaluator_spec(hardware.evaluator).design
            target = target._replace(table=make_table(design, hardware.evaluator.kept_lines, base))
            base += -(-rows * ENTRY_BYTES // LINE_BYTES) * LINE_BYTES
        targets.append(target)
    if base > hardware.machine.dram_bytes:
        what = f"the maps take {base} bytes; the memory has {hardware.machine.dram_bytes}"
        raise fail(what, key="machine.components")
    return targets


def phase_of(shadow_map: ShadowMap) -> str:
    """The name of a map's phase."""
    return f"map_{shadow_map.name.replace(' ', '_')}"


def play_maps(
    model: str,
    hardware: Hardware,
    mesh: Mesh,
    maps: Sequence[ShadowMap],
    targets: Sequence[Target],
    progress: Progress = silent,
    listen: Listen = to_nothing,
) -> list[PlayedMap]:
    """Draw a mesh into each map on the hardware; who listens hears of each as a phase."""
    played = []
    for number, (shadow_map, target) in enumerate(zip(maps, targets, strict=True)):
        progress("shadow maps", number, len(maps))
        vertices = map_vertices(mesh, shadow_map)
        work, state = tile_work(vertices, mesh.triangles, target)
        machine = hardware.machine
        counters = play(model, machine, work, None, listen(phase_of(shadow_map), machine))
        drawn = draw(vertices, mesh.triangles, target.grid, target.offset)
        rows, columns = drawn.depth.shape
        depth = state.depth[:rows, :columns]
        finished = _finished(hardware.codec, state, drawn.touched)
        played.append(PlayedMap(shadow_map, target, drawn, depth, counters, state.moved, finished))
    progress("shadow maps", len(maps), len(maps))
    return played


def _finished(codec: CodecSpec, state: ZState, touched: np.ndarray) -> tuple[int, int]:
    """Bytes of the touched blocks of a finished map: plain, and as memory would hold them."""
    blocks = touched_blocks(touched, codec.side)
    held = int(tile_bits(codec, state.depth, blocks).sum()) // 8
    return int(blocks.sum()) * plain_bytes(codec), held


def touched_blocks(touched: np.ndarray, side: int) -> np.ndarray:
    """Bool [block rows, block columns]: blocks of `side` samples with a tile that is `touched`."""
    each = side // TILE
    rows, columns = (-(-length // each) * each for length in touched.shape)
    whole = np.zeros((rows, columns), np.bool_)
    whole[: touched.shape[0], : touched.shape[1]] = touched
    return np.asarray(whole.reshape(rows // each, each, columns // each, each).any(axis=(1, 3)))
