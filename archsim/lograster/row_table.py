"""A table of G(y') in memory, and the few lines of it that the fine rasterizer keeps. [Lloyd07] sec. 4.2.2

Tiles come in an order that is known beforehand, so lines are asked for ahead of the tiles that need them: the
work has a LOAD for each line that is not among those kept, and the unit that plays it sends its loads ahead.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import fail
from archsim.jit import njit
from archsim.lograster.evaluators import Design
from archsim.lograster.grid import TILE

LINE_BYTES = 64
ENTRY_BYTES = 4  # 24 bits, aligned
NO_LINE = -1


class TableSpec(NamedTuple):
    """Where the table is and how much of it is kept."""

    rows_each: int  # entries that a tile needs: 4, or 1 where the others follow from it; 0: there is no table
    kept_lines: int  # lines kept, least recently used first out
    base: int  # address of the first entry


NO_TABLE = TableSpec(0, 1, 0)


def make_table(design: int, kept_lines: int, base: int) -> TableSpec:
    """The table of an evaluator design, if it has one."""
    if kept_lines < 1:
        raise fail(f"a table needs at least one line to be kept, not {kept_lines}")
    rows_each = {Design.TABLE: TILE, Design.TABLE_FIRST_ROW: 1}.get(Design(design), 0)
    return TableSpec(rows_each, kept_lines, base)


def empty_buffer(table: TableSpec) -> np.ndarray:
    """Lines kept, most recently used first; int64 [kept_lines]."""
    return np.full(table.kept_lines, NO_LINE, dtype=np.int64)


@njit
def missing_line(table, kept, tile_row):
    """The line that a row of tiles needs if it is not kept, else NO_LINE; it is the most recent one
    afterwards.
    """
    if table.rows_each == 0:
        return NO_LINE
    line = tile_row * table.rows_each * ENTRY_BYTES // LINE_BYTES
    place = 0
    while place < len(kept) - 1 and kept[place] != line:
        place += 1
    was_kept = kept[place] == line
    for i in range(place, 0, -1):
        kept[i] = kept[i - 1]
    kept[0] = line
    return NO_LINE if was_kept else line
