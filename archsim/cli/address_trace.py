"""What `archsim trace` does with address traces."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from archsim.cli.bars import Bars
from archsim.cli.configs import find_config, find_run
from archsim.cli.run import report_failed
from archsim.config import MachineConfig, load_machine, load_run
from archsim.config.components import CoreConfig
from archsim.config.dram import DramConfig, IdealDramConfig
from archsim.errors import did_you_mean, fail
from archsim.machine.build import group_machine
from archsim.machine.play import MODELS
from archsim.report.formats import number, words
from archsim.run.export import export
from archsim.run.folder import MANIFEST, as_json
from archsim.run.replay import Play, Replay, level_named, replay_with_time, replay_without_time
from archsim.run.replay_dram import dram_part, replay_on_dram
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
    Console().print(table)


class ReplayOptions(NamedTuple):
    """The options of `archsim trace replay`."""

    machine: str
    overrides: list[str]
    to: str
    cores: str | None
    functional: bool
    flush: bool | None
    outstanding: int
    model: str


def replay(file: Path, form_name: str, options: ReplayOptions, json_only: bool) -> None:
    """Replay a trace and print what it found."""
    form = format_named(form_name)
    machine = load_machine(find_config("machines", options.machine), options.overrides)
    _check(options)
    with Bars() as bars:
        found = _replayed(file, form, machine, options, bars)
    if json_only:
        print(as_json(found.tree()), end="")
    else:
        _print_replay(found)
    report_failed((found.name, check) for check in found.checks)


def _check(options: ReplayOptions) -> None:
    """ArchsimError for options that do not go together."""
    if options.flush and not options.functional:
        raise fail("--flush: only with --functional")
    if options.functional and options.to == "dram":
        raise fail("--functional: a DRAM is replayed with time only")
    if options.model not in MODELS:
        raise fail(f"--model: no model is named '{options.model}'", hint=did_you_mean(options.model, MODELS))


def _replayed(file: Path, form: Format, machine: MachineConfig, options: ReplayOptions, bars: Bars) -> Replay:
    name = f"{file.name} on {machine.name}"
    if (
        options.to == "dram"
        or machine.find(options.to, DramConfig)
        or machine.find(options.to, IdealDramConfig)
    ):
        part = dram_part(machine, None if options.to == "dram" else options.to)
        return replay_on_dram(name, read_accesses(file, form), part, options.model)

    def reopen() -> Accesses:
        return read_accesses(file, form)

    phase = group_machine(machine, _group(machine, options.cores))
    level = level_named(phase, options.to)
    if options.functional:
        ends_flushed = form.language in (Language.DINERO, Language.XDIN)
        flush = ends_flushed if options.flush is None else options.flush
        return replay_without_time(name, reopen, phase, level, flush)
    return replay_with_time(name, reopen, phase, level, Play(options.model, options.outstanding, bars))


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
    Console().print(table)


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
