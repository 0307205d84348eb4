"""`archsim whatif`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rich import box
from rich.table import Table

from archsim.cli.configs import find_run
from archsim.cli.console import terminal
from archsim.cli.watch import LiveTable
from archsim.config import load_run, resolved_yaml
from archsim.report.formats import number
from archsim.run.folder import as_json, write_whole
from archsim.sweep.plan import make_plan
from archsim.sweep.start import run_sweep
from archsim.sweep.store import BASE, check_folder
from archsim.sweep.table import load_table, write_table
from archsim.sweep.whatif import Outcome, outcomes, whatif_sweep
from archsim.sweep.workers import LocalWorkers

_SHOWN_PAIRS = 10


def whatif(run: str, overrides: list[str], out: Path | None, jobs: int, how: tuple[bool, bool]) -> None:
    """Measure every ideal part of a run's machine, print the ranked speed-ups; `how`: with pairs, as JSON."""
    pairs, json_only = how
    config = load_run(find_run(run), overrides)
    folder = out or Path("runs") / f"whatif-{config.name}"
    check_folder(folder)
    base = folder / BASE
    write_whole(base, resolved_yaml(config))
    sweep, chosen = whatif_sweep(config, str(base), pairs)
    plan = make_plan(sweep.config, str(base))
    with LiveTable() as table:
        run_sweep(sweep, str(base), (plan, plan), folder, (LocalWorkers(jobs), "1of1", table))
    write_table(folder)
    found = outcomes(chosen, _cycles(folder))
    if json_only:
        print(as_json([outcome._asdict() for outcome in found]), end="")
        return
    _print(found, len(chosen) - len(found))
    print(f"written to {folder} (archsim sweep table {folder})")


def _cycles(folder: Path) -> list[Mapping[str, float] | None]:
    """Cycles of every phase, for each point in order; None where it failed."""
    table = load_table(folder)
    columns = [name for name in table.columns if name.endswith(".cycles")]
    return [
        {name.removesuffix(".cycles"): float(row[name]) for name in columns}
        if row["status"] == "finished"
        else None
        for _, row in table.iterrows()
    ]


def _print(found: list[Outcome], failed: int) -> None:
    console = terminal()
    single = [outcome for outcome in found if len(outcome.ideas) < 2]
    console.print(_table("What if there were", single))
    if len(single) < len(found):
        pairs = [outcome for outcome in found if len(outcome.ideas) == 2]
        console.print(
            _table(f"Two at a time, the best {min(_SHOWN_PAIRS, len(pairs))}", pairs[:_SHOWN_PAIRS])
        )
    if failed:
        print(f"{failed} ideas could not be measured; see `archsim sweep table`")


def _table(title: str, found: list[Outcome]) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("")
    table.add_column("speed-up", justify="right")
    phases = list(found[0].cycles) if found else []
    for phase in phases:
        table.add_column(f"{phase}\ncycles", justify="right")
    for outcome in found:
        cycles = [number(int(outcome.cycles[phase])) for phase in phases]
        table.add_row(" + ".join(outcome.ideas) or "the machine as it is", f"{outcome.speedup:.3f}", *cycles)
    return table
