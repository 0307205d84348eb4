"""The folder of a sweep. What is in it is whole: everything is written beside its name and renamed when done.

sweep.json               the sweep's name, its points: parameters, command, digest; and who set their values
points/DIGEST/           result.json, config.yaml, manifest.json of a finished point
failed/DIGEST.json       why a point has no result, and the command that repeats it
work/DIGEST/             a picture's work while points are played on it
run.yaml                 of `archsim whatif`: the run that its points start from
table.parquet, report.html
"""

from __future__ import annotations

import fcntl
import json
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from archsim.config import RunConfig, resolved_yaml
from archsim.config.explain import Origin
from archsim.errors import Location, fail
from archsim.run.folder import MANIFEST, as_json, check_writable, publish, result_json, write_whole
from archsim.run.manifest import make_manifest
from archsim.run.result import Result

INDEX = "sweep.json"
BASE = "run.yaml"  # of `archsim whatif`: the run that its points start from


class IndexEntry(NamedTuple):
    """A point as the index keeps it."""

    parameters: dict[str, Any]
    command: str
    digest: str


class Index(NamedTuple):
    """What `sweep.json` holds."""

    name: str
    metrics: tuple[str, ...]
    points: list[IndexEntry]
    set_by_sweep: list[Origin]  # what the sweep sets, with the values that points have
    of_run: list[Origin]  # of the run that points start from


def check_folder(folder: Path) -> None:
    """Raise ArchsimError if the folder is neither new, nor empty, nor a sweep's, or cannot be written to.

    A sweep that has no index yet, just begun or killed at once, has its base and hidden files only.
    """
    check_writable(folder)
    others = (path.name for path in folder.iterdir()) if folder.is_dir() else iter(())
    strange = any(name != BASE and not name.startswith(".") for name in others)
    if strange and not (folder / INDEX).is_file():
        raise fail("holds something else than a sweep", Location(str(folder)), "name a new folder with --out")


def write_index(folder: Path, index: Index) -> None:
    """Write `sweep.json`; the same sweep gives the same bytes."""
    tree = index._asdict() | {"points": [entry._asdict() for entry in index.points]}
    write_whole(folder / INDEX, as_json(tree))


def read_index(folder: Path) -> Index:
    """Raises ArchsimError if the folder is not a sweep's."""
    if not (folder / INDEX).is_file():
        raise fail(f"is not a sweep: it has no {INDEX}", Location(str(folder)))
    try:
        tree = json.loads((folder / INDEX).read_text(encoding="utf-8"))
        points = [IndexEntry(**entry) for entry in tree["points"]]
        set_by = (_origins(tree[key]) for key in ("set_by_sweep", "of_run"))
        return Index(tree["name"], tuple(tree["metrics"]), points, *set_by)
    except (ValueError, KeyError, TypeError) as error:
        raise fail(f"is broken: {error}", Location(str(folder / INDEX))) from None


def is_finished(folder: Path, digest: str) -> bool:
    """Whether the point's result is there."""
    return (folder / "points" / digest / MANIFEST).is_file()


def write_point(
    folder: Path, digest: str, config: RunConfig, result: Result, seconds: float, command: str
) -> None:
    """Keep a point's result; a failure of an earlier attempt is forgotten."""
    config_yaml = resolved_yaml(config)
    manifest = make_manifest(config_yaml, config.seed, result.scene_digest, [command], seconds)

    def fill(temporary: Path) -> None:
        (temporary / "result.json").write_text(result_json(result), encoding="utf-8")
        (temporary / "config.yaml").write_text(config_yaml, encoding="utf-8")
        (temporary / MANIFEST).write_text(as_json(manifest), encoding="utf-8")

    publish(folder / "points" / digest, True, fill)
    _failure(folder, digest).unlink(missing_ok=True)


def write_failure(folder: Path, digest: str, error: str, command: str) -> None:
    """Keep why a point has no result."""
    write_whole(_failure(folder, digest), as_json({"error": error, "command": command}))


def read_failure(folder: Path, digest: str) -> str | None:
    """Why a point has no result; None if it was not tried."""
    path = _failure(folder, digest)
    return str(json.loads(path.read_text(encoding="utf-8"))["error"]) if path.is_file() else None


@contextmanager
def only_one(folder: Path, name: str) -> Iterator[None]:
    """Hold a lock that dies with the process. Raises ArchsimError if another process holds it."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f".{name}.lock").open("w") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise fail("another process is working on this sweep", Location(str(folder))) from None
        yield


def sweep_out(folder: Path, digests: Iterable[str], work: str) -> None:
    """Remove what a killed process left half done: of these points, and all work of this name."""
    for digest in digests:
        for leftover in (folder / "points").glob(f".{digest}-unfinished-*"):
            shutil.rmtree(leftover, ignore_errors=True)
    shutil.rmtree(folder / "work" / work, ignore_errors=True)


def _origins(rows: Iterable[Iterable[str]]) -> list[Origin]:
    return [Origin(*row) for row in rows]


def _failure(folder: Path, digest: str) -> Path:
    return folder / "failed" / f"{digest}.json"
