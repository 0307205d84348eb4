"""What DRAMsim3 reads and writes: its configuration, its traces, its commands and its statistics."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from archsim.model.dram.commands import COMMAND, Command
from archsim.model.dram.spec import DramSpec
from archsim.trace.accesses import Kind

NEVER = 10**12  # a clock that no simulation reaches
PREFIX = "dramsim3"
DEVICE_BITS = 8
COLUMN = (Command.RD, Command.WR)
_COMMANDS = {
    "activate": Command.ACT,
    "precharge": Command.PRE,
    "read": Command.RD,
    "write": Command.WR,
    "refresh": Command.REF,
}
_FIELDS = {"row": "ro", "bank": "ba", "line": "co", "group": "bg", "channel": "ch"}


class Policy(NamedTuple):
    """How its controller works; what is here is what comes nearest to ours."""

    queue_structure: str = "PER_RANK"
    cmd_queue_size: int = 32  # commands that the scheduler sees, of a rank or of each bank
    trans_queue_size: int = 1  # requests that wait in front of that
    unified_queue: str = "true"  # whether reads and writes wait together


class Run(NamedTuple):
    """A trace that was served."""

    commands: np.ndarray  # COMMAND
    statistics: dict[str, Any]  # of its only channel


def configuration(spec: DramSpec, policy: Policy) -> str:
    """The INI file of a DRAM of one channel. ValueError for what it cannot say."""
    timing = spec.timing
    if spec.num_channels != 1 or spec.bank_hash or timing.n_rc != timing.n_ras + timing.n_rp:
        raise ValueError("one channel, no hash of banks, n_rc = n_ras + n_rp")
    if timing.n_rcd_read != timing.n_rcd_write or spec.clock_beats != 2:
        raise ValueError("one n_rcd, two beats a clock")
    rows, row_bytes = 1 << spec.row.bits, _row_bytes(spec)
    sections = {
        "dram_structure": {
            "protocol": "DDR4" if spec.num_groups > 1 else "DDR3",
            "bankgroups": spec.num_groups,
            "banks_per_group": spec.num_banks // spec.num_groups,
            "rows": rows,
            "columns": row_bytes // spec.beat_bytes,
            "device_width": DEVICE_BITS,
            "BL": spec.burst_beats,
        },
        "timing": {
            "tCK": 1,
            "CL": timing.n_cl,
            "CWL": timing.n_wl,
            "tRCD": timing.n_rcd_read,
            "tRP": timing.n_rp,
            "tRAS": timing.n_ras,
            "tRFC": timing.n_rfc,
            "tREFI": timing.n_refi,
            "tRRD_S": timing.n_rrd,
            "tRRD_L": timing.n_rrd_l,
            "tWTR_S": timing.n_wtr,
            "tWTR_L": timing.n_wtr_l,
            "tFAW": timing.n_faw,
            "tWR": timing.n_wr,
            "tRTP": timing.n_rtp,
            "tCCD_S": timing.n_ccd,
            "tCCD_L": timing.n_ccd_l,
            "tRTRS": timing.n_rtw - (timing.n_cl + spec.burst_clocks - timing.n_wl),
        },
        "system": {
            "channel_size": rows * row_bytes * spec.num_banks >> 20,
            "channels": 1,
            "bus_width": 8 * spec.beat_bytes,
            "address_mapping": _address_mapping(spec),
            "row_buf_policy": "OPEN_PAGE",
            "refresh_policy": "RANK_LEVEL_STAGGERED",
            **policy._asdict(),
        },
        "other": {"epoch_period": 2**31 - 1, "output_level": 1, "output_prefix": PREFIX},
    }
    lines = [
        [f"[{section}]", *(f"{name} = {value}" for name, value in values.items())]
        for section, values in sections.items()
    ]
    return "\n".join("\n".join(each) + "\n" for each in lines)


def trace_text(requests: np.ndarray) -> str:
    """The trace of ACCESS records, and behind them a request that is never made.

    Without it the last line would be made twice, or not at all if it does not end.
    """
    lines = [
        f"{access['address']:#x} {'WRITE' if access['kind'] == Kind.WRITE else 'READ'} {access['cycle']}"
        for access in requests
    ]
    return "\n".join([*lines, f"0x0 READ {NEVER}"]) + "\n"


def commands_of(text: str, spec: DramSpec) -> np.ndarray:
    """COMMAND records of the command trace that it writes if it is built for that."""
    lines = [line.split() for line in text.splitlines()]
    found = np.zeros(len(lines), COMMAND)
    found["clock"] = [int(line[0]) for line in lines]
    found["command"] = [_COMMANDS[line[1]] for line in lines]
    groups, banks, rows, columns = np.array([[int(word, 0) for word in line[4:8]] for line in lines]).T
    has_bank, has_row = found["command"] != Command.REF, np.isin(found["command"], (Command.ACT, *COLUMN))
    found["bank"] = np.where(has_bank, banks * spec.num_groups + groups, 0)
    found["row"] = np.where(has_row, rows, 0)
    is_column = np.isin(found["command"], COLUMN)
    found["column"], found["bursts"] = np.where(is_column, columns, 0), is_column
    return found


def run(binary: Path, folder: Path, config: str, requests: np.ndarray, spec: DramSpec, clocks: int) -> Run:
    """Simulate a trace for so many clocks. ChildProcessError if it fails, ValueError if it is not built for it."""
    (folder / "config.ini").write_text(config)
    (folder / "trace.txt").write_text(trace_text(requests))
    command = [binary, folder / "config.ini", "-c", str(clocks), "-t", folder / "trace.txt", "-o", folder]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ChildProcessError(f"{binary}: {done.stderr or done.stdout}")
    traces = [path for path in folder.iterdir() if re.search(r"ch_0cmd\.trace$", path.name)]
    if not traces:
        raise ValueError(f"{binary}: wrote no commands; build it with -DCMD_TRACE=1")
    statistics = json.loads((folder / f"{PREFIX}.json").read_text())["0"]
    return Run(commands_of(traces[0].read_text(), spec), statistics)


def _row_bytes(spec: DramSpec) -> int:
    """Bytes of a row: what the address names below it, without its bank and group."""
    return 1 << (spec.row.shift - spec.bank.bits - spec.group.bits)


def _address_mapping(spec: DramSpec) -> str:
    """Its six fields from the highest to the lowest; those of no bits come first."""
    places = {name: getattr(spec, name) for name in _FIELDS}
    used = sorted((name for name in places if places[name].bits), key=lambda name: -places[name].shift)
    unused = [name for name in places if not places[name].bits]
    return "ra" + "".join(_FIELDS[name] for name in [*unused, *used])
