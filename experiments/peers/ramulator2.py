"""What Ramulator 2 reads and writes: its configuration, its traces, its commands and its statistics."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np

from archsim.model.dram.commands import COMMAND, Command
from archsim.model.dram.spec import DramSpec
from archsim.trace.accesses import Kind

DEVICE_BITS = 8
RATE = 3200  # it wants one, and uses it for what is overridden here
COLUMN = (Command.RD, Command.WR)
_COMMANDS = {
    "ACT": Command.ACT,
    "PRE": Command.PRE,
    "PREA": Command.PREA,
    "RD": Command.RD,
    "WR": Command.WR,
    "REFab": Command.REF,
}


class Run(NamedTuple):
    """A trace that was played."""

    commands: np.ndarray  # COMMAND
    read_latency: float  # clocks, mean over the reads that were answered


def configuration(spec: DramSpec, interval_clocks: int, folder: Path) -> str:
    """The YAML file of one rank of DDR4 chips. ValueError for what it cannot say.

    `interval_clocks` lie between two requests, if the queues have room.
    """
    timing = spec.timing
    order = [spec.line.shift, spec.group.shift, spec.bank.shift, spec.row.shift]
    if spec.num_channels != 1 or spec.num_groups == 1 or spec.bank_hash or order != sorted(order):
        raise ValueError("one channel, bank groups, no hash of banks, row:bank:group:line:channel:offset")
    if (
        timing.n_rcd_read != timing.n_rcd_write
        or timing.n_rtw != timing.n_cl + spec.burst_clocks + 2 - timing.n_wl
    ):
        raise ValueError("one n_rcd, n_rtw = n_cl + burst + 2 - n_wl")
    return f"""\
Frontend: {{impl: LoadStoreTrace, clock_ratio: 1, path: {folder / "trace.txt"}}}
MemorySystem:
  impl: GenericDRAM
  clock_ratio: {interval_clocks}
  DRAM: {{impl: DDR4, org: {_flow(_organization(spec))}, timing: {_flow(_clocks(spec))}}}
  AddrMapper: {{impl: RoBaRaCoCh}}
  Controller:
    impl: Generic
    Scheduler: {{impl: FRFCFS}}
    RefreshManager: {{impl: AllBank}}
    RowPolicy: {{impl: OpenRowPolicy}}
    plugins:
      - ControllerPlugin: {{impl: TraceRecorder, path: {folder / "commands"}}}
"""


def _organization(spec: DramSpec) -> dict[str, int]:
    columns = (1 << spec.group.shift) // spec.beat_bytes
    rows = 1 << spec.row.bits
    return {
        "dq": DEVICE_BITS,
        "density": spec.num_banks * rows * columns * DEVICE_BITS >> 20,
        "channel_width": 8 * spec.beat_bytes,
        "channel": 1,
        "rank": 1,
        "bankgroup": spec.num_groups,
        "bank": spec.num_banks // spec.num_groups,
        "row": rows,
        "column": columns,
    }


def _clocks(spec: DramSpec) -> dict[str, int]:
    timing = spec.timing
    return {
        "rate": RATE,
        "nBL": spec.burst_clocks,
        "nCL": timing.n_cl,
        "nRCD": timing.n_rcd_read,
        "nRP": timing.n_rp,
        "nRAS": timing.n_ras,
        "nRC": timing.n_rc,
        "nWR": timing.n_wr,
        "nRTP": timing.n_rtp,
        "nCWL": timing.n_wl,
        "nCCDS": timing.n_ccd,
        "nCCDL": timing.n_ccd_l,
        "nRRDS": timing.n_rrd,
        "nRRDL": timing.n_rrd_l,
        "nWTRS": timing.n_wtr,
        "nWTRL": timing.n_wtr_l,
        "nFAW": timing.n_faw,
        "nRFC": timing.n_rfc,
        "nREFI": timing.n_refi,
        "nCS": 2,
    }


def _flow(values: dict[str, int]) -> str:
    return "{" + ", ".join(f"{name}: {value}" for name, value in values.items()) + "}"


def trace_text(requests: np.ndarray) -> str:
    """The trace of ACCESS records; their cycles are not said."""
    lines = [
        f"{'ST' if access['kind'] == Kind.WRITE else 'LD'} {access['address']:#x}" for access in requests
    ]
    return "\n".join(lines) + "\n"


def commands_of(text: str, spec: DramSpec) -> np.ndarray:
    """COMMAND records of what its TraceRecorder wrote: clock, command, channel, rank, group, bank, row, burst."""
    lines = [line.split(", ") for line in text.splitlines()]
    found = np.zeros(len(lines), COMMAND)
    found["clock"] = [int(line[0]) for line in lines]
    found["command"] = [_COMMANDS[line[1]] for line in lines]
    groups, banks, rows, bursts = np.array([[int(word) for word in line[4:8]] for line in lines]).T
    has_bank = ~np.isin(found["command"], (Command.REF, Command.PREA))
    has_row, is_column = np.isin(found["command"], (Command.ACT, *COLUMN)), np.isin(found["command"], COLUMN)
    found["bank"] = np.where(has_bank, banks * spec.num_groups + groups, 0)
    found["row"] = np.where(has_row, rows, 0)
    found["column"], found["bursts"] = np.where(is_column, bursts, 0), is_column
    return found


def run(binary: Path, folder: Path, requests: np.ndarray, spec: DramSpec, interval_clocks: int) -> Run:
    """Simulate a trace until its last request is taken. ChildProcessError if it fails, ValueError if it cannot be."""
    config = folder / "config.yaml"
    config.write_text(configuration(spec, interval_clocks, folder))
    (folder / "trace.txt").write_text(trace_text(requests))
    done = subprocess.run([binary, "-f", config], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ChildProcessError(f"{binary}: {done.stderr or done.stdout}")
    commands = commands_of((folder / "commands.ch0").read_text(), spec)
    is_read = commands["command"] == Command.RD
    if np.count_nonzero(is_read) > np.count_nonzero(requests["kind"] != Kind.WRITE):
        raise ValueError(f"{binary}: takes stores for loads; its loadstore_trace.cpp has them mixed up")
    data = commands["clock"][is_read] + spec.timing.n_cl + spec.burst_clocks
    num_answered = np.count_nonzero(data <= _statistic(done.stdout, "memory_system_cycles"))
    return Run(commands, _statistic(done.stdout, "read_latency_0") / max(num_answered, 1))


def _statistic(text: str, name: str) -> int:
    found = re.search(rf"\b{name}: (\d+)", text)
    if found is None:
        raise ValueError(f"Ramulator 2 does not print '{name}'")
    return int(found[1])
