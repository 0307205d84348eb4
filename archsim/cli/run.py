"""`archsim run`."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import typer

from archsim.cli.bars import Bars
from archsim.cli.configs import find_run
from archsim.cli.console import print_summary
from archsim.cli.edge import FAILED_CHECK
from archsim.cli.timeline import parse_window, write_timelines
from archsim.config import Loaded, load_run_with_origins, resolved_yaml
from archsim.config.explain import origins
from archsim.report.run_page import run_report
from archsim.run import simulate
from archsim.run.folder import RunFiles, check_target, result_json, write_run
from archsim.run.manifest import make_manifest
from archsim.run.result import Check, Result


def run(
    config_name: str, overrides: list[str], out: Path | None, as_json: bool, cycles: str | None = None
) -> None:
    """Simulate, write the run folder, say where it is."""
    check_target(out)
    window = None if cycles is None else parse_window(cycles)
    loaded = load_run_with_origins(find_run(config_name), overrides)
    config = loaded.config

    started = time.perf_counter()
    with Bars() as bars, loaded.locating():
        result = simulate(config, bars)
    folder = write_run(out, run_files(result, loaded, time.perf_counter() - started))

    phases = [] if window is None else write_timelines(config, window, folder)

    if as_json:
        print(result_json(result), end="")
    else:
        print_summary(result)
        print(f"written to {folder} (open {folder}/report.html)")
        for phase in phases:
            print(
                f"and {folder}/timeline-{phase}.json (open it with https://ui.perfetto.dev), waterfall-{phase}.svg"
            )
    report_failed((result.name, check) for check in result.checks)


def run_files(result: Result, loaded: Loaded[Any], wall_seconds: float) -> RunFiles:
    """Everything that is kept of a finished run or walkthrough."""
    config_yaml, seed = resolved_yaml(loaded.config), loaded.config.seed
    manifest = make_manifest(config_yaml, seed, result.scene_digest, sys.argv, wall_seconds)
    return RunFiles(result, config_yaml, manifest, run_report(result, config_yaml, manifest, origins(loaded)))


def report_failed(checks: Iterable[tuple[str, Check]]) -> None:
    """A law that does not hold is said loudly, by the name of what was simulated: on stderr, and by exit code 1."""
    failed = [(name, check) for name, check in checks if not check.ok]
    for name, check in failed:
        print(f"{name}: check failed: {check.name}: {check.detail}", file=sys.stderr)
    if failed:
        raise typer.Exit(FAILED_CHECK)
