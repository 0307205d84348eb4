"""An irregular shadow map rendered once: its picture and its work, kept in a folder, to be played on many machines."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from archsim.config import GridConfig, RunConfig
from archsim.machine.build import phase_machine
from archsim.run.izb_picture import Emitted, Picture, ViewLaws, compose, find
from archsim.run.izb_statistics import BUILD
from archsim.run.izb_subject import subject_of
from archsim.run.izb_work import Recorded, prepare
from archsim.trace.records import Tasks, joined


class RenderedIzb(NamedTuple):
    """All that does not depend on the machine."""

    picture: Picture
    views: list[Recorded]
    laws: list[ViewLaws]


def depends_on_machine(config: RunConfig) -> dict[str, Any]:
    """What the work takes from the machine: the number of threads that tiles or nodes are dealt to."""
    assert isinstance(config.workload, GridConfig)
    if config.workload.tile_order != "block" and config.workload.node_layout != "pool":
        return {}
    core = phase_machine(config.machine, BUILD).spec.core
    return {"build_threads": core.num_cores * core.num_threads}


def render(config: RunConfig) -> RenderedIzb:
    """Execute the kernels of a run; no machine is played."""
    subject = subject_of(config)
    views = prepare(config, subject)
    recorded, found = [], []
    for view in views:
        emitted = Emitted([], [])
        recorded.append(view.recorded(emitted.take))
        found.append(find(view, emitted))
    return RenderedIzb(compose(subject, views, found), recorded, [each.laws for each in found])


def save(rendered: RenderedIzb, folder: Path) -> None:
    """Write into an empty folder; the work as plain arrays, so that it need not be read as a whole."""
    for number, view in enumerate(rendered.views):
        _save_tasks(folder / f"view{number}_clear", view.clear)
        _save_tasks(folder / f"view{number}_build", view.build)
        _save_tasks(folder / f"view{number}_raster", view.raster)
    bare = [view._replace(clear=[], build=[], raster=[]) for view in rendered.views]
    (folder / "rendered.pickle").write_bytes(pickle.dumps(rendered._replace(views=bare)))


def load(folder: Path) -> RenderedIzb:
    """What `save` wrote."""
    rendered: RenderedIzb = pickle.loads((folder / "rendered.pickle").read_bytes())
    views = [
        view._replace(
            clear=_load_tasks(folder / f"view{number}_clear"),
            build=_load_tasks(folder / f"view{number}_build"),
            raster=_load_tasks(folder / f"view{number}_raster"),
        )
        for number, view in enumerate(rendered.views)
    ]
    return rendered._replace(views=views)


def _save_tasks(folder: Path, chunks: list[Tasks]) -> None:
    """All chunks behind each other: `lengths` [num_tasks] records of each task, `chunks` tasks of each chunk."""
    folder.mkdir()
    np.save(folder / "chunks.npy", np.array([tasks.num_tasks for tasks in chunks], np.int64))
    lengths = [np.diff(tasks.starts) for tasks in chunks]
    np.save(folder / "lengths.npy", np.concatenate(lengths) if lengths else np.zeros(0, np.int64))
    np.save(folder / "records.npy", joined([tasks.records for tasks in chunks]))


def _load_tasks(folder: Path) -> list[Tasks]:
    chunks, lengths, records = (np.load(folder / f"{name}.npy") for name in ("chunks", "lengths", "records"))
    starts = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    ends = np.cumsum(chunks)
    return [
        Tasks(starts[first : last + 1] - starts[first], records[starts[first] : starts[last]])
        for first, last in zip(ends - chunks, ends, strict=True)
    ]
