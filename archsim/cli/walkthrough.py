"""`archsim walkthrough`."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from archsim import resources
from archsim.cli.bars import Bars
from archsim.cli.console import print_summary
from archsim.cli.run import report_failed, run_files
from archsim.config import load_walkthrough_with_origins
from archsim.run.folder import check_target, result_json, write_run
from archsim.run.walkthrough import simulate_walkthrough


def walkthrough(config_name: str, overrides: list[str], out: Path | None, as_json: bool) -> None:
    """Draw all frames, write the folder, say where it is; frames are kept beside it until it is there."""
    loaded = load_walkthrough_with_origins(_find(config_name), overrides)
    config = loaded.config
    target = out or Path("runs") / f"walkthrough-{config.name}"
    check_target(target)
    unfinished = frames_beside(target)

    started = time.perf_counter()
    with Bars() as bars, loaded.locating():
        result = simulate_walkthrough(config, bars, unfinished)
    folder = write_run(target, run_files(result, loaded, time.perf_counter() - started))
    shutil.rmtree(unfinished, ignore_errors=True)

    if as_json:
        print(result_json(result), end="")
    else:
        print_summary(result)
        print(f"written to {folder} (open {folder}/report.html)")
    report_failed((result.name, check) for check in result.checks)


def frames_beside(target: Path) -> Path:
    """Where the frames are kept of walkthroughs whose results will be in `target`."""
    return target.with_name(f".{target.name}-frames")


def _find(name: str) -> str:
    """The path of a walkthrough: `name` itself if it is a file, else that of the row PAPER/ROW of an experiment."""
    paper, _, row = name.partition("/")
    packaged = resources.experiment(paper) / f"{row}.yaml"
    return str(packaged) if row and not Path(name).is_file() and packaged.is_file() else name
