"""The evaluators of section 4.2.2 on the tile pipeline: does each sustain a tile a clock?"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim import resources
from archsim.config import load_machine
from archsim.lograster.offset import OffsetSpec, Switch
from archsim.run.tile_pipeline import Hardware, hardware_of, play_maps, targets_of
from archsim.scene.mesh import Mesh
from archsim.shadowmap.fit import NO_REGION, ShadowMap

MAP_ROWS = 4096
DESIGNS: dict[str, dict[str, str | int]] = {  # keys of the machine's evaluator
    "full": {"design": "full", "exponentials": 4},
    "full, one exponential": {"design": "full", "exponentials": 1},
    "incremental": {"design": "incremental", "exponentials": 1},
    "table of rows": {"design": "table", "table_ports": 4},
    "table of first rows": {"design": "table_first_row", "table_ports": 1},
}
SIDE, RATIO = 1024, 1000.0
SQUARE = Mesh(
    np.array([(0, 0, 0.5), (1, 0, 0.5), (1, 1, 0.5), (0, 1, 0.5)], dtype=np.float32),
    np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32),
)
WHOLE_MAP = ShadowMap("square", np.eye(4), RATIO, NO_REGION, np.array([0.0, 0, 1, 0]))


class Sustained(NamedTuple):
    """A square over the whole of a map, drawn with one design."""

    cycles: int
    tiles: int
    table_bytes: int  # read from memory


def hardware_with(name: str) -> Hardware:
    """The paper's machine with one of DESIGNS."""
    overrides = [f"components.evaluator.{key}={value}" for key, value in DESIGNS[name].items()]
    return hardware_of(load_machine(resources.config("machines", "lloyd2007"), overrides))


def play_designs() -> dict[str, Sustained]:
    """Each design on a map of SIDE x SIDE samples."""
    return {name: _play(hardware_with(name)) for name in DESIGNS}


def _play(hardware: Hardware) -> Sustained:
    offset = OffsetSpec(0.0, 0.0, int(Switch.INTERPOLATED))
    targets = targets_of(hardware.parts, [WHOLE_MAP], [(SIDE, SIDE)], offset)
    (played,) = play_maps("compiled", hardware, SQUARE, [WHOLE_MAP], targets)
    return Sustained(played.counters.cycles, played.tasks("fine"), played.table_read)
