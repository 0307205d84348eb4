"""Arguments and options that several verbs have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Set a value, e.g. scene.resolution=[640,512]. Repeatable."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON to stdout and nothing else.")]
Out = Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Folder for the results.")]
Jobs = Annotated[int, typer.Option("--jobs", min=1, metavar="N", help="Processes.")]
RunName = Annotated[str, typer.Argument(metavar="RUN", help="A run's YAML file, or a packaged run's name.")]
KernelName = Annotated[str, typer.Argument(metavar="FILE", help="An assembly file, or a kernel's name.")]
