"""What `archsim trace` does with address traces."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import NamedTuple

from rich.table import Table

from archsim.cli.bars import Bars
from archsim.cli.configs import find_config, find_run
from archsim.cli.console import terminal
from archsim.cli.run import report_failed
from archsim.config import MachineConfig, load_machine, load_run
from archsim.config.components import CoreConfig
from archsim.config.dram import DramConfig, IdealDramConfig
from archsim.errors import did_you_mean, fail
from archsim.machine.build import group_machine
from archsim.machine.command_trace import written_commands
from archsim.machine.play import MODELS
from archsim.model.dram.commands import CommandSink
from archsim.model.dram.spec import DramSpec, Scheduler
from archsim.report.formats import number, words
from archsim.run.export import export
from archsim.run.folder import MANIFEST, as_json
from archsim.run.replay import Replay, level_named, replay_without_time
from archsim.run.replay_dram import dram_part, replay_on_dram
from archsim.run.replay_timed import Play, replay_with_time
from archsim.trace.accesses import Accesses
from archsim.trace.files import read_accesses, trace_writer
from archsim.trace.formats.languages import Format, Language, format_named
from archsim.trace.summary import summarize


def info(file: Path, form: str, json_only: bool) -> None:
    """Print what the trace holds."""
    summary = summarize(read_accesses(file, format_named(form)))
    if json_only:
        print(as_json(summary._asdict()), end="")
        return
    table = Table(show_header=False, pad_edge=False, box=None)
    table.add_column()
    table.add_column(justify="right")
    for name, value in summary._asdict().items():
        table.add_row(words(name), hex(value) if name.endswith("_address") else number(value))
    terminal().print(table)


class Where(NamedTuple):
    """Who gets the accesses of a trace."""

    machine: str
    overrides: list[str]
    to: str  # a level
    cores: str | None

    @property
    def is_dram(self) -> bool:
        return self.to == "dram"


class How(NamedTuple):
    """When the accesses are made, and what is written besides."""

    functional: bool
    at_cycles: bool
    outstanding: int
    flush: bool | None
    model: str
    commands: Path | None


def replay(file: Path, form_name: str, where: Where, how: How, json_only: bool) -> None:
    """Replay a trace and print what it found."""
    form = format_named(form_name)
    machine = load_machine(find_config("machines", where.machine), where.overrides)
    is_named = machine.find(where.to, DramConfig) or machine.find(where.to, IdealDramConfig)
    on_dram = where.is_dram or is_named is not None
    _check(form, on_dram, how)
    with Bars() as bars:
        found = (_on_dram if on_dram else _on_caches)((file, form), machine, where, how, bars)
    if json_only:
        print(as_json(found.tree()), end="")
    else:
        _print_replay(found)
    report_failed((found.name, check) for check in found.checks)


def _check(form: Format, on_dram: bool, how: How) -> None:
    """ArchsimError for options that do not go together."""
    if how.flush and on_dram:
        raise fail("--flush: a DRAM has nothing to write back")
    if how.functional and on_dram:
        raise fail("--functional: a DRAM is replayed with time only")
    if how.functional and (how.at_cycles or how.commands):
        raise fail(
            f"{'--at-cycles' if how.at_cycles else '--commands'}: not with --functional, which has no time"
        )
    if how.at_cycles and not form.has_cycles:
        raise fail(f"--at-cycles: '{form.name}' does not say when", hint="dramsim3 and csv do")
    if how.model not in MODELS:
        raise fail(f"--model: no model is named '{how.model}'", hint=did_you_mean(how.model, MODELS))


def _on_dram(
    trace: tuple[Path, Format], machine: MachineConfig, where: Where, how: How, bars: Bars
) -> Replay:
    part = dram_part(machine, None if where.is_dram else where.to)
    with _recorded(how, part.spec) as sink:
        return replay_on_dram(
            f"{trace[0].name} on {machine.name}", read_accesses(*trace), part, how.model, sink
        )


def _on_caches(
    trace: tuple[Path, Format], machine: MachineConfig, where: Where, how: How, bars: Bars
) -> Replay:
    name = f"{trace[0].name} on {machine.name}"

    def reopen() -> Accesses:
        return read_accesses(*trace)

    phase = group_machine(machine, _group(machine, where.cores))
    level = level_named(phase, where.to)
    if how.functional:
        ends_flushed = trace[1].language in (Language.DINERO, Language.XDIN)
        return replay_without_time(
            name, reopen, phase, level, ends_flushed if how.flush is None else how.flush
        )
    play = Play(how.model, how.outstanding, bars, how.at_cycles, bool(how.flush), partial(_recorded, how))
    return replay_with_time(name, reopen, phase, level, play)


def _recorded(how: How, spec: DramSpec) -> AbstractContextManager[CommandSink | None]:
    """Who takes the DRAM's commands. ArchsimError for a DRAM that has none."""
    if how.commands is None:
        return nullcontext()
    if spec.scheduler == Scheduler.IDEAL:
        raise fail("--commands: an ideal DRAM has no commands")
    return written_commands(spec, how.commands)


def _group(machine: MachineConfig, name: str | None) -> str:
    """The group of cores of that name, the first one without a name."""
    groups = list(machine.all_of(CoreConfig))
    if name is None and groups:
        return groups[0]
    if name not in groups:
        hint = did_you_mean(name or "", groups) or f"there are: {', '.join(groups)}"
        raise fail(f"the machine has no cores '{name}'", hint=hint)
    return name


def _print_replay(found: Replay) -> None:
    units = {statistic.name: statistic.unit for statistic in found.statistics}
    table = Table(title=found.name, title_justify="left", show_header=False, pad_edge=False, box=None)
    table.add_column()
    table.add_column(justify="right")
    table.add_column()
    for name, value in found.summary.items():
        table.add_row(words(name), number(value), units.get(name, ""))
    for bucket in found.latency:
        table.add_row(f"reads of {bucket.least} to {bucket.most} clocks", number(bucket.reads), "reads")
    terminal().print(table)


def export_run(
    run: str, form_name: str, at: str, phase: str | None, out: Path | None, overrides: list[str]
) -> None:
    """Write a run's requests at one level, and say where."""
    form = format_named(form_name)
    folder = Path(run)
    config_file = folder / "config.yaml" if (folder / MANIFEST).is_file() else None
    config = load_run(config_file or find_run(run), overrides)
    target = out or Path(f"{config.name}-{at.lower()}.{form.name}")
    with Bars() as bars, trace_writer(target, form) as writer:
        result = export(config, at, phase, writer.write, bars)
    print(f"{writer.count:,} requests at {at} written to {target}")
    report_failed((result.name, check) for check in result.checks)
