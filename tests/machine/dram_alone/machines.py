"""DRAMs of the packaged presets, and streams of requests for them."""

from pathlib import Path

import numpy as np

from archsim import resources
from archsim.config import load_machine
from archsim.config.dram import DramConfig
from archsim.machine.build import dram_spec
from archsim.machine.dram_alone.stream import Requests

PRESETS = sorted(path.stem for path in Path(resources.root() / "configs" / "dram").glob("*.yaml"))
COMMANDED = [name for name in PRESETS if name != "ideal"]
LINE_BYTES = 128


def preset(name, *overrides):
    """The DRAM of a preset on the machine of the paper."""
    path = "components.dram"
    first = [f"{path}={{base: dram/{name}.yaml}}", "clocks.memory=700 MHz"]
    if name != "ideal":
        first.append(f"{path}.frequency=null")
    machine = load_machine("machines/johnson2004.yaml", [*first, *(f"{path}.{each}" for each in overrides)])
    return machine.components["dram"]


def spec_of(dram, line_bytes=LINE_BYTES):
    return dram_spec(dram, line_bytes, 1)


def random_stream(dram: DramConfig, count, seed, line_bytes=LINE_BYTES, writes=0.3, gap=0):
    """Half the requests anywhere, half near one of a few places; every `gap` clocks on average."""
    rng = np.random.default_rng(seed)
    lines = dram.capacity_bytes // line_bytes
    anywhere = rng.integers(0, lines, count)
    near = (
        rng.integers(0, 4, count) * (lines // 4) + np.arange(count) % 97 + rng.integers(0, 3, count)
    ) % lines
    addresses = np.where(rng.random(count) < 0.5, anywhere, near) * line_bytes
    arrivals = np.cumsum(rng.integers(0, 2 * gap + 1, count))
    return Requests(addresses, rng.random(count) < writes, arrivals)
