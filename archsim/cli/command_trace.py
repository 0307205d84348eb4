"""What `archsim trace` does with DRAM command traces."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import typer

from archsim.cli.bars import Bars
from archsim.cli.configs import find_config, find_run
from archsim.cli.edge import FAILED_CHECK
from archsim.cli.run import report_failed
from archsim.config import load_machine, load_run
from archsim.config.dram import DramConfig
from archsim.config.machine import MachineConfig
from archsim.errors import Location, Problem, did_you_mean, fail
from archsim.machine.command_trace import written_commands
from archsim.run.folder import as_json
from archsim.run.recording import record_commands
from archsim.trace.referee.commands import Issued, read_commands
from archsim.trace.referee.rules import Violation, violations

MOST_SHOWN = 100  # violations; the rest is counted


def record_dram(run: str, overrides: list[str], phase: str | None, out: Path) -> None:
    """Simulate a run and write the commands of its DRAM in one phase."""
    config = load_run(find_run(run), overrides)
    with Bars() as bars:
        result = record_commands(config, phase, lambda spec: written_commands(spec, out), bars)
    print(f"written to {out} (archsim trace check-dram {out} --machine {config.machine.name})")
    report_failed((result.name, check) for check in result.checks)


def check_dram(file: Path, machine: str, dram: str | None, overrides: list[str], json_only: bool) -> None:
    """Print the violations in a command trace; ends with exit code 1 if there are any."""
    config = _dram_of(load_machine(find_config("machines", machine), overrides), dram)
    counted: Counter[str] = Counter()
    by_rule: Counter[str] = Counter()
    shown: list[Violation] = []
    for violation in violations(config, _counting(read_commands(file), counted)):
        by_rule[violation.rule] += 1
        if len(shown) < MOST_SHOWN:
            shown.append(violation)
            if not json_only:
                print(Problem(Location(str(file), violation.line), f"{violation.rule}: {violation.what}"))
    if json_only:
        found = {"commands": dict(counted), "violations": dict(by_rule)}
        print(as_json({**found, "first": [violation._asdict() for violation in shown]}), end="")
    else:
        _print_sum(counted, by_rule, len(shown))
    if by_rule:
        raise typer.Exit(FAILED_CHECK)


def _dram_of(machine: MachineConfig, name: str | None) -> DramConfig:
    """The DRAM of that name, or the only one."""
    drams = machine.all_of(DramConfig)
    if name is None:
        if len(drams) != 1:
            what = f"the machine has {len(drams)} DRAMs with commands"
            raise fail(what, hint=f"--dram {' or '.join(drams)}" if drams else None)
        return next(iter(drams.values()))
    if name not in drams:
        hint = did_you_mean(name, drams) or f"there are: {', '.join(drams)}"
        raise fail(f"--dram: no DRAM with commands is named '{name}'", hint=hint)
    return drams[name]


def _counting(commands: Iterator[Issued], counted: Counter[str]) -> Iterator[Issued]:
    for command in commands:
        counted[command.command] += 1
        yield command


def _print_sum(counted: Counter[str], by_rule: Counter[str], num_shown: int) -> None:
    total, broken = sum(counted.values()), sum(by_rule.values())
    if broken > num_shown:
        print(f"... and {broken - num_shown:,} more")
    kinds = ", ".join(f"{count:,} {name}" for name, count in sorted(counted.items()))
    rules = ", ".join(f"{count:,} of {name}" for name, count in sorted(by_rule.items()))
    word = "violation" if broken == 1 else "violations"
    judgement = f"{broken:,} {word} ({rules})" if broken else "no violation"
    print(f"{total:,} commands ({kinds}): {judgement}")
