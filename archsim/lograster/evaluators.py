"""Three ways to have G(y') of a tile's rows in hardware, and what each costs. [Lloyd07] sec. 4.2.2

Whatever the design, a row has one G for all triangles, so that edges stay watertight; the designs differ in
how nearly the samples lie where eq. 5 puts them, in area, and in time.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.config.tiles import EvaluatorConfig
from archsim.errors import fail
from archsim.lograster.grid import TILE, Grid
from archsim.lograster.parameterization import log_unwarp

EDGES = 3


class Design(IntEnum):
    """Where G(y') of the four rows of a tile comes from."""

    FULL = 0  # an exponential for each row
    INCREMENTAL = 1  # one exponential, and a multiply-add for each row below the first
    TABLE = 2  # a table of all rows
    TABLE_FIRST_ROW = 3  # a table of the tiles' first rows, and a multiply-add for each row below


class EvaluatorSpec(NamedTuple):
    """An evaluator: what the paper leaves to the designer."""

    design: int  # Design
    exponentials: int  # units, each starts one evaluation a clock; without effect in the table designs
    exponential_cycles: int  # latency of one
    multiply_cycles: int  # latency of a multiply-add
    table_ports: int  # rows that one table access delivers
    table_cycles: int  # latency of a table access


class EvaluatorCost(NamedTuple):
    """What an evaluator takes, for three edges and the depth of one 4 x 4 tile."""

    exponentials: int  # units
    multipliers: int  # of edges, depth, and G where it is incremental
    adders: int  # that extend the first column to the other three
    table_bytes: int
    table_reads: int  # for each tile
    latency_cycles: int  # from y' to coverage
    interval_cycles: int  # clocks from one tile to the next: 1 is the paper's goal


def evaluator_cost(spec: EvaluatorSpec, rows: int, bits: int) -> EvaluatorCost:
    """The cost of an evaluator for a map of `rows` rows, with G of `bits` bits."""
    check_evaluator(spec)
    equations = EDGES + 1
    from_table = spec.design in (Design.TABLE, Design.TABLE_FIRST_ROW)
    one_row = spec.design in (Design.INCREMENTAL, Design.TABLE_FIRST_ROW)

    wanted = 1 if one_row else TILE
    entries = 0 if not from_table else rows // TILE if one_row else rows
    source_cycles = spec.table_cycles if from_table else spec.exponential_cycles
    units = spec.table_ports if from_table else spec.exponentials
    return EvaluatorCost(
        exponentials=0 if from_table else spec.exponentials,
        multipliers=equations * TILE + (TILE - 1 if one_row else 0),
        adders=equations * TILE * (TILE - 1),
        table_bytes=-(-entries * bits // 8),
        table_reads=wanted if from_table else 0,
        latency_cycles=source_cycles + (1 + one_row) * spec.multiply_cycles + 1,
        interval_cycles=-(-wanted // units),
    )


def evaluator_spec(config: EvaluatorConfig) -> EvaluatorSpec:
    """What a checked section describes."""
    return EvaluatorSpec(
        design=int(Design[config.design.upper()]),
        exponentials=config.exponentials,
        exponential_cycles=config.exponential_cycles,
        multiply_cycles=config.multiply_cycles,
        table_ports=config.table_ports,
        table_cycles=config.table_cycles,
    )


def check_evaluator(spec: EvaluatorSpec) -> None:
    """Whether the numbers can be."""
    if min(spec.exponentials, spec.table_ports) < 1:
        raise fail("an evaluator needs at least one exponential unit and one table port")
    if min(spec.exponential_cycles, spec.multiply_cycles, spec.table_cycles) < 1:
        raise fail("exponentials, multiply-adds and table accesses take at least one clock")


def with_rows(grid: Grid, design: int, constant_bits: int) -> Grid:
    """The grid with its rows where a design puts them.

    The incremental designs compute G(y'0) P_k + Q_k (eq. 7, 8) with constants of `constant_bits` fraction
    bits, in fixed point, and round the sum to the grid.
    """
    if design in (Design.FULL, Design.TABLE):
        return grid
    if not 1 <= constant_bits <= 36:
        raise fail(f"the constants of an incremental evaluator have 1 to 36 bits, not {constant_bits}")
    y = grid.y.copy()
    factors, terms = incremental_constants(len(y), grid.ratio, constant_bits)
    shift = constant_bits
    for k in range(1, TILE):
        y[k::TILE] = (y[::TILE] * factors[k] + (terms[k] << grid.bits) + (1 << (shift - 1))) >> shift
    return grid._replace(y=y)


def incremental_constants(rows: int, ratio: float, bits: int) -> tuple[list[int], list[int]]:
    """P_k and Q_k of eq. 8 for k = 0 ... 3, as whole multiples of 2^-bits."""
    scale = float(1 << bits)
    steps = [k / rows for k in range(TILE)]
    factors = [math.exp(-step * math.log(ratio)) for step in steps]
    terms = log_unwarp(np.array(steps), ratio)
    return [round(factor * scale) for factor in factors], [round(float(term) * scale) for term in terms]


def row_error(grid: Grid, design: int, constant_bits: int) -> int:
    """How far a design moves a row at most, in units of the coordinate grid."""
    return int(np.abs(with_rows(grid, design, constant_bits).y - grid.y).max())
