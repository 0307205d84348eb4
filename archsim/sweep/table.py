"""The results of a sweep as one table: a row a point, a column a parameter or statistic."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import pandas as pd

from archsim.errors import ArchsimError, Problem, did_you_mean
from archsim.run.folder import MANIFEST, write_whole
from archsim.sweep.expand import flow
from archsim.sweep.store import IndexEntry, read_failure, read_index

TABLE = "table.parquet"
_OWN = ("point", "status", "error", "seconds", "command")


def load_table(folder: Path) -> pd.DataFrame:
    """The table of a sweep's folder as it is now; statistics of points without a result are NaN."""
    index = read_index(folder)
    rows = [_row(folder, entry) for entry in index.points]
    table = pd.DataFrame(rows)
    for name in parameters_of(folder):
        table[name] = _column([entry.parameters.get(name) for entry in index.points])
    return table


def write_table(folder: Path) -> Path:
    """Write `table.parquet`, for pandas, DuckDB and others."""
    stream = io.BytesIO()
    load_table(folder).to_parquet(stream, index=False)
    write_whole(folder / TABLE, stream.getvalue())
    return folder / TABLE


def parameters_of(folder: Path) -> list[str]:
    """The parameters that differ between points, in the order of the sweep's file."""
    entries = read_index(folder).points
    names = dict.fromkeys(name for entry in entries for name in entry.parameters)
    return [name for name in names if len({flow(entry.parameters.get(name)) for entry in entries}) > 1]


def metrics_of(folder: Path, table: pd.DataFrame) -> list[str]:
    """What is to be small, of what the table has: what the sweep's file names, else the cycles of every phase."""
    named = read_index(folder).metrics or [name for name in table.columns if name.endswith(".cycles")]
    return [name for name in named if name in table.columns]


def check_metrics(folder: Path, table: pd.DataFrame) -> None:
    """Raise ArchsimError if the sweep's file names a metric that no finished point has."""
    known = [str(name) for name in table.columns]
    unknown = [name for name in read_index(folder).metrics if name not in known]
    if unknown and (table["status"] == "finished").any():
        whats = [(f"no point has the metric '{name}'", did_you_mean(name, known)) for name in unknown]
        raise ArchsimError([Problem(None, what, hint) for what, hint in whats])


def units_of(folder: Path) -> dict[str, str]:
    """statistic -> unit, of the finished points."""
    found: dict[str, str] = {}
    for entry in read_index(folder).points:
        own = folder / "points" / entry.digest
        if (own / MANIFEST).is_file():
            result = json.loads((own / "result.json").read_text(encoding="utf-8"))
            found |= {item["name"]: item["unit"] for item in result["statistics"]}
    return found


def _column(values: list[Any]) -> pd.Series:
    """A parameter's values; whole numbers stay whole beside points that don't set it, mixed types become text."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int}:
        return pd.Series(values, dtype="Int64" if None in values else "int64")
    if kinds == {int, float}:
        return pd.Series(values, dtype="float64")
    scalars = [_scalar(value) for value in values]
    if len(kinds) > 1 or kinds & {list, dict, str}:
        return pd.Series([None if value is None else str(value) for value in scalars], dtype=object)
    return pd.Series(scalars)


def _row(folder: Path, entry: IndexEntry) -> dict[str, Any]:
    own = folder / "points" / entry.digest
    parameters = {name: _scalar(value) for name, value in entry.parameters.items()}
    row = {"point": entry.digest, **parameters, "status": "finished", "error": None, "command": entry.command}
    if not (own / MANIFEST).is_file():
        error = read_failure(folder, entry.digest)
        return row | {"status": "unfinished" if error is None else "failed", "error": error}

    result = json.loads((own / "result.json").read_text(encoding="utf-8"))
    manifest = json.loads((own / MANIFEST).read_text(encoding="utf-8"))
    statistics = {item["name"]: item["value"] for item in result["statistics"]}
    return row | {"seconds": manifest["wall_seconds"], **statistics}


def _scalar(value: Any) -> Any:
    """A value that fits a column: lists and mappings become text."""
    return value if isinstance(value, str | int | float | bool | None) else flow(value)
