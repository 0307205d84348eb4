"""`archsim trace`: address traces that other simulators read and write."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from archsim.cli.edge import at_the_edge
from archsim.cli.options import Json, RunName
from archsim.cli.sections import Sectioned

trace_app = typer.Typer(
    name="trace",
    help="Address traces (the formats of Dinero, Ramulator and DRAMsim3, and CSV) and DRAM command traces.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

TraceFile = Annotated[Path, typer.Argument(metavar="FILE", help="An address trace; .gz is read too.")]
FormatName = Annotated[
    str,
    typer.Option("--format", metavar="NAME", help="dinero, xdin, ramulator, ramulator2, dramsim3 or csv."),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Set a value of the machine or run. Repeatable."),
]
Phase = Annotated[
    str | None,
    typer.Option("--phase", metavar="NAME", help="As statistics begin: izb_build, say."),
]


@trace_app.command("info")
@at_the_edge
def _info(file: TraceFile, form: FormatName, as_json: Json = False) -> None:
    """Count a trace's accesses, bytes and footprint."""
    from archsim.cli.address_trace import info

    info(file, form, as_json)


_WHERE, _WHEN, _OUTPUT = "Where the accesses go", "When they are made", "What comes out"

# Options of `archsim trace replay`, by section.
_MachineName = Annotated[
    str,
    typer.Option(
        "--machine",
        metavar="NAME",
        help="A machine's YAML file, or a packaged machine's name.",
        rich_help_panel=_WHERE,
    ),
]
_Level = Annotated[
    str,
    typer.Option(
        "--to",
        metavar="LEVEL",
        help="Who gets the accesses: l1, l2 ..., a cache's name, or dram.",
        rich_help_panel=_WHERE,
    ),
]
_Cores = Annotated[
    str | None,
    typer.Option(
        "--cores",
        metavar="NAME",
        help="Whose caches; the first group of cores if not given.",
        rich_help_panel=_WHERE,
    ),
]
_MachineOverrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Set a value of the machine. Repeatable.", rich_help_panel=_WHERE
    ),
]
_Outstanding = Annotated[
    int,
    typer.Option(
        "--outstanding",
        min=1,
        max=1024,
        help="Accesses under way, for a single requester; the next one is made when one is answered.",
        rich_help_panel=_WHEN,
    ),
]
_AtCycles = Annotated[
    bool,
    typer.Option(
        "--at-cycles",
        help="At their cycles in the trace, whatever was answered; a DRAM does so anyway.",
        rich_help_panel=_WHEN,
    ),
]
_Functional = Annotated[
    bool,
    typer.Option(
        "--functional",
        help="Without time: each is finished before the next; caches only.",
        rich_help_panel=_WHEN,
    ),
]
_Flush = Annotated[
    bool | None,
    typer.Option(
        "--flush/--no-flush",
        help="Write dirty lines back at the end; the default for dinero and xdin with --functional.",
        rich_help_panel=_WHEN,
    ),
]
_Model = Annotated[str, typer.Option("--model", metavar="reference|compiled", rich_help_panel=_WHEN)]
_Commands = Annotated[
    Path | None,
    typer.Option(
        "--commands",
        metavar="FILE",
        help="Write the DRAM's commands, for archsim trace check-dram.",
        rich_help_panel=_OUTPUT,
    ),
]


@trace_app.command("replay", cls=Sectioned)
@at_the_edge
def _replay(
    file: TraceFile,
    form: FormatName,
    machine: _MachineName,
    to: _Level = "l1",
    cores: _Cores = None,
    overrides: _MachineOverrides = None,
    outstanding: _Outstanding = 1,
    at_cycles: _AtCycles = False,
    functional: _Functional = False,
    flush: _Flush = None,
    model: _Model = "compiled",
    as_json: Json = False,
    commands: _Commands = None,
) -> None:
    """Play a trace on a machine's caches and DRAM and print what it finds there."""
    from archsim.cli.address_trace import How, Where, replay

    where = Where(machine, overrides or [], to, cores)
    how = How(functional, at_cycles, outstanding, flush, model, commands)
    replay(file, form, where, how, as_json)


@trace_app.command("check-dram")
@at_the_edge
def _check_dram(
    file: Annotated[Path, typer.Argument(metavar="COMMANDS", help="A DRAM command trace; .gz is read too.")],
    machine: Annotated[
        str,
        typer.Option(
            "--machine", metavar="NAME", help="A machine's YAML file, or a packaged machine's name."
        ),
    ],
    dram: Annotated[
        str | None, typer.Option("--dram", metavar="NAME", help="The DRAM, if the machine has several.")
    ] = None,
    overrides: Overrides = None,
    as_json: Json = False,
) -> None:
    """Judge a DRAM command trace by every rule of the machine's data sheet; exit code 1 if one is broken."""
    from archsim.cli.command_trace import check_dram

    check_dram(file, machine, dram, overrides or [], as_json)


@trace_app.command("record-dram")
@at_the_edge
def _record_dram(
    run: RunName,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The command trace to be written.")],
    phase: Phase = None,
    overrides: Overrides = None,
) -> None:
    """Simulate a run and write every command of its DRAM in one phase: clock,channel,command,bank,row,column."""
    from archsim.cli.command_trace import record_dram

    record_dram(run, overrides or [], phase, out)


@trace_app.command("export")
@at_the_edge
def _export(
    run: Annotated[
        str, typer.Argument(metavar="RUN", help="A run's YAML file, a packaged run's name, or a run folder.")
    ],
    form: FormatName,
    at: Annotated[
        str, typer.Option("--at", metavar="LEVEL", help="L1, L2 ..., a cache's name, or dram.")
    ] = "L1",
    phase: Phase = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The trace; compressed if it ends in .gz.")
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Simulate a run and write the requests that reach a level of its machine, in all its phases or in one."""
    from archsim.cli.address_trace import export_run

    export_run(run, form, at, phase, out, overrides or [])
