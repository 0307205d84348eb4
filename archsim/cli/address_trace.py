"""What `archsim trace` does with address traces."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.table import Table

from archsim.report.formats import number, words
from archsim.run.folder import as_json
from archsim.trace.files import read_accesses
from archsim.trace.formats.languages import format_named
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
