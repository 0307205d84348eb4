"""The run folder: written beside its final name, renamed when whole; a killed run leaves nothing that looks finished.

A folder is an archsim run when it holds `manifest.json`, which is written last.
"""

from __future__ import annotations

import errno
import io
import itertools
import json
import math
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from archsim.errors import Location, fail
from archsim.model.latency import shortest
from archsim.run.result import Check, Result, Statistic

MANIFEST = "manifest.json"
_LIT, _SHADOWED = (255, 247, 222), (38, 52, 94)  # RGB of shadow.png


class StoredRun(NamedTuple):
    """A run folder, read back."""

    path: Path
    result: Result  # without histograms and maps; the mask is empty if the folder, a sweep's point, has none
    config_yaml: str
    manifest: dict[str, Any]


class RunFiles(NamedTuple):
    """What goes into a run folder, besides the pictures made of the result."""

    result: Result
    config_yaml: str
    manifest: Mapping[str, Any]
    report_html: str


def write_run(out: Path | None, files: RunFiles) -> Path:
    """Write a run folder and return its path. `out` None: a fresh name below `runs/`.

    Raises ArchsimError if `out` is neither new nor an archsim run, or cannot be written.
    """
    if out is None:
        fresh = Path("runs") / (re.sub(r"[^A-Za-z0-9._-]+", "-", files.result.name).strip(".-") or "run")
        return publish(fresh, False, lambda folder: fill_run(folder, files))
    return publish(out, True, lambda folder: fill_run(folder, files))


def publish(target: Path, replace: bool, fill: Callable[[Path], None]) -> Path:
    """Let `fill` write into a folder beside `target`, then give it that name; returns the name it got.

    `replace`: an archsim folder of that name is replaced; at every moment there is the old one, the new one, or none.
    Otherwise the first free one of `target`, `target-2`, `target-3` ... is taken.
    """
    place = target.resolve()
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(prefix=f".{place.name}-unfinished-", dir=place.parent))
        try:
            temporary.chmod(0o755)
            fill(temporary)
            if replace:
                _rename_over(temporary, place)
                return target
            return target.with_name(_rename_to_free(temporary, place))
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    except OSError as error:
        raise fail(f"cannot write the folder: {error.strerror or error}", Location(str(target))) from None


def check_target(out: Path | None) -> None:
    """Raise ArchsimError if a run can't be written to `out`: better before the work than after it."""
    if out is None:
        return
    check_writable(out)
    if out.is_dir() and any(out.iterdir()) and not (out / MANIFEST).is_file():
        raise fail(
            "holds something else than an archsim run", Location(str(out)), "name a new folder with --out"
        )


def check_writable(out: Path) -> None:
    """Raise ArchsimError if `out` is not a folder that can be written to, or made."""
    if os.path.lexists(out) and not out.is_dir():
        raise fail("is not a folder", Location(str(out)), "name a new folder with --out")
    existing = next(folder for folder in (out.absolute(), *out.absolute().parents) if folder.exists())
    if not existing.is_dir():
        raise fail(f"'{existing}' is not a folder", Location(str(out)), "name a new folder with --out")
    if not os.access(existing, os.W_OK):
        raise fail(f"'{existing}' cannot be written to", Location(str(out)), "name another folder with --out")


def result_json(result: Result) -> str:
    """The text of `result.json`: the same run gives the same bytes; what is not finite becomes null."""
    tree = {
        "name": result.name,
        "summary": result.summary,
        "statistics": [statistic._asdict() for statistic in result.statistics],
        "checks": [check._asdict() for check in result.checks],
        "latencies": {level: _classes(counts) for level, counts in result.latencies.items()},
        "series": {phase: series._asdict() for phase, series in result.series.items()},
    }
    return as_json(tree)


def _classes(counts: np.ndarray) -> dict[str, list[int]]:
    """The classes of latency that have requests: the shortest latency of each, and how many."""
    filled = np.flatnonzero(counts).tolist()
    return {"from_cycles": [shortest(each) for each in filled], "requests": counts[filled].tolist()}


def as_json(tree: Any) -> str:
    """JSON text of a tree of plain values and numpy numbers."""
    return json.dumps(plain(tree), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def plain(value: Any) -> Any:
    """`value` in the types that JSON has; NaN and infinities become None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def load_folder(path: Path) -> StoredRun:
    """Read a run folder; raises ArchsimError naming the file that is missing or broken."""
    if not path.is_dir():
        raise fail("no such run folder", Location(str(path)))
    if not (path / MANIFEST).is_file():
        raise fail(f"is not an archsim run: it has no {MANIFEST}", Location(str(path)))

    tree, manifest = _read_json(path / "result.json"), _read_json(path / MANIFEST)
    try:
        result = Result(
            name=tree["name"],
            scene_digest=manifest["scene_digest"],
            summary=tree["summary"],
            statistics=[Statistic(**_finite(item)) for item in tree["statistics"]],
            checks=[Check(**item) for item in tree["checks"]],
            shadow=_read_shadow(path / "shadow.npy"),
            histograms=[],
            maps={},
        )
    except (KeyError, TypeError) as error:
        raise fail(f"is not a result: {error}", Location(str(path / "result.json"))) from None
    return StoredRun(path, result, _read_text(path / "config.yaml"), manifest)


def fill_run(folder: Path, files: RunFiles) -> None:
    """Write every file of a run, the manifest last."""
    folder.mkdir(exist_ok=True)
    (folder / "result.json").write_text(result_json(files.result), encoding="utf-8")
    (folder / "config.yaml").write_text(files.config_yaml, encoding="utf-8")
    np.save(folder / "shadow.npy", np.asarray(files.result.shadow, dtype=bool))
    (folder / "shadow.png").write_bytes(png(shadow_colours(files.result.shadow)))
    (folder / "report.html").write_text(files.report_html, encoding="utf-8")
    (folder / MANIFEST).write_text(as_json(files.manifest), encoding="utf-8")


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file so that it is there as a whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}-unfinished-", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content if isinstance(content, bytes) else content.encode())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def shadow_colours(shadow: np.ndarray) -> np.ndarray:
    """The mask as an image uint8 [height, width, 3], shadow dark."""
    return np.array([_LIT, _SHADOWED], dtype=np.uint8)[np.asarray(shadow, dtype=np.intp)]


def png(colours: np.ndarray) -> bytes:
    """An image uint8 [height, width, 3] as a PNG, row 0 at the top."""
    from matplotlib.image import imsave  # late: slow to import

    stream = io.BytesIO()
    imsave(stream, colours, format="png")
    return stream.getvalue()


def _rename_over(temporary: Path, place: Path) -> None:
    """Rename, with whatever archsim folder has that name moved away before and deleted after."""
    check_target(place)
    retired = temporary.with_name(f"{temporary.name}-replaced")
    if place.exists():
        place.rename(retired)
    temporary.rename(place)
    shutil.rmtree(retired, ignore_errors=True)


def _rename_to_free(temporary: Path, place: Path) -> str:
    """Rename to the first free name, which is returned; another process may take names at the same time."""
    for number in itertools.count(1):
        candidate = place if number == 1 else place.with_name(f"{place.name}-{number}")
        if os.path.lexists(candidate):
            continue
        try:
            temporary.rename(candidate)
            return candidate.name
        except OSError as error:
            if error.errno not in (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR):
                raise
    raise AssertionError("there are always free names")


def _finite(item: dict[str, Any]) -> dict[str, Any]:
    """A statistic's fields; null was not finite."""
    return item | {"value": math.nan if item["value"] is None else item["value"]}


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise fail(
            f"cannot be read: {getattr(error, 'strerror', None) or error}", Location(str(path))
        ) from None


def _read_json(path: Path) -> dict[str, Any]:
    try:
        tree = json.loads(_read_text(path))
    except json.JSONDecodeError as error:
        raise fail(f"is not JSON: {error.msg}", Location(str(path), error.lineno, error.colno)) from None
    if not isinstance(tree, dict):
        raise fail("is not a JSON object", Location(str(path)))
    return tree


def _read_shadow(path: Path) -> np.ndarray:
    if not path.exists():
        return np.zeros((0, 0), np.bool_)
    try:
        shadow = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise fail(f"cannot be read: {error}", Location(str(path))) from None
    if shadow.dtype != np.bool_ or shadow.ndim != 2:
        raise fail("is not a mask of bool [height, width]", Location(str(path)))
    return shadow
