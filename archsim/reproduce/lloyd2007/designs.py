"""The evaluators of section 4.2.2 on the tile pipeline: does each sustain a tile a clock?"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim import resources
from archsim.codec.codec import Codec, make_codec
from archsim.config import load_machine
from archsim.lograster.evaluators import Design, EvaluatorSpec, evaluator_cost
from archsim.lograster.grid import BITS, make_grid
from archsim.lograster.row_table import make_table
from archsim.lograster.work import COARSE, FINE, Target, tile_work
from archsim.lograster.z_cache import make_z_cache
from archsim.machine.pipeline.build import PipelineMachine, pipeline_machine
from archsim.machine.pipeline.play import play

MAP_ROWS = 4096
EVALUATOR = EvaluatorSpec(Design.FULL, 4, 11, 3, 4, 2)
DESIGNS = {
    "full": EVALUATOR,
    "full, one exponential": EVALUATOR._replace(exponentials=1),
    "incremental": EVALUATOR._replace(design=Design.INCREMENTAL, exponentials=1),
    "table of rows": EVALUATOR._replace(design=Design.TABLE),
    "table of first rows": EVALUATOR._replace(design=Design.TABLE_FIRST_ROW, table_ports=1),
}
SQUARE = np.array([(0, 0, 0.5, 1), (1, 0, 0.5, 1), (1, 1, 0.5, 1), (0, 1, 0.5, 1)], dtype=np.float64)
SQUARE_TRIANGLES = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32)
SIDE, RATIO = 1024, 1000.0
KEPT_LINES = 16
TABLE_BASE = 1 << 24


class Sustained(NamedTuple):
    """A square over the whole of a map, drawn with one design."""

    cycles: int
    tiles: int
    table_bytes: int  # read from memory


def play_designs() -> dict[str, Sustained]:
    """Each design on a map of SIDE x SIDE samples."""
    return {name: _play(spec) for name, spec in DESIGNS.items()}


def _play(evaluator: EvaluatorSpec) -> Sustained:
    target = Target(
        make_grid(SIDE, SIDE, RATIO),
        make_codec(Codec.LLOYD, granularity_bits=128),
        make_z_cache(48 * 512, 4),
        table=make_table(evaluator.design, KEPT_LINES, TABLE_BASE),
    )
    work, _ = tile_work(SQUARE, SQUARE_TRIANGLES, target)
    counters = play("compiled", machine_with(evaluator), work)
    return Sustained(counters.cycles, int(counters.unit_tasks[FINE]), int(counters.unit_load_bytes[FINE]))


def machine_with(evaluator: EvaluatorSpec) -> PipelineMachine:
    """The paper's machine with an evaluator's latency, and its interval from tile to tile."""
    has_table = evaluator.design in (Design.TABLE, Design.TABLE_FIRST_ROW)
    name = "lloyd2007_table" if has_table else "lloyd2007"
    machine = pipeline_machine(load_machine(resources.config("machines", name)))
    cost = evaluator_cost(evaluator, SIDE, BITS)
    units = list(machine.spec.units)
    units[COARSE] = units[COARSE]._replace(latency_cycles=cost.latency_cycles)
    units[FINE] = units[FINE]._replace(
        latency_cycles=cost.latency_cycles, interval_cycles=cost.interval_cycles
    )
    return machine._replace(spec=machine.spec._replace(units=tuple(units)))
